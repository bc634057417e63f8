// A recorded breath: the track of a marker on chest or abdomen, converted to a surrogate signal.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace stylet::patient {

struct RecordedBreath {
    // one sample every dt_s, a closed loop between end-exhales; median end-exhale is 0, median end-inhale
    // 1
    std::vector<double> v;
    double dt_s = 0.1;
    double period_s = 0.0;  // of the median breath
    double travel_m = 0.0;  // of the marker in the median breath
    int breaths = 0;
    // Rows that were dropped: time out of order, trailing zeros.
    int misdated_rows = 0, zero_rows = 0;
};

// CSV "Frame;Timestamp;x;y;z" (Krilavicius et al. 2013): milliseconds and millimetres, decimal comma or
// point, z increases as the body rises. Drops trailing rows of zeros. Drops rows whose time is out of order
// if they are few. Throws DataError with the file, the row or field, and the reason.
RecordedBreath loadRecordedBreath(const std::filesystem::path& csv);
// The same from memory; `file` is used in error messages only.
RecordedBreath parseRecordedBreath(std::string_view csv, const std::filesystem::path& file);

}  // namespace stylet::patient
