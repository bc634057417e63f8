// A recorded breath: the track of a marker on chest or belly, made a surrogate signal.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace stylet::patient {

struct RecordedBreath {
    std::vector<double> v;  // one every dt_s, a closed loop from end-exhale to end-exhale; ends 0, peaks 1
    double dt_s = 0.1;
    double period_s = 0.0;  // median breath
    double travel_m = 0.0;  // of the marker, median breath
    int breaths = 0;
    // What the file held besides: rows dated out of order, rows of zeros behind its end.
    int misdated_rows = 0, zero_rows = 0;
};

// CSV "Frame;Timestamp;x;y;z" (Krilavicius et al. 2013): milliseconds and millimetres, decimal comma or
// point, z grows as the body rises. Trailing rows of zeros are dropped; rows whose time breaks the order are
// left out where few and short. Throws DataError: file, row or field, reason.
RecordedBreath loadRecordedBreath(const std::filesystem::path& csv);
// The same by its contents; `file` is named when they are refused.
RecordedBreath parseRecordedBreath(std::string_view csv, const std::filesystem::path& file);

}  // namespace stylet::patient
