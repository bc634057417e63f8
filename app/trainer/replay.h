// `stylet replay`: a record computed again, watched or just checked.
#pragma once

#include <filesystem>
#include <optional>

namespace stylet::trainer {

struct ReplayOptions {
    std::filesystem::path record;   // the record's folder, or the attempt's that holds it
    std::filesystem::path patient;  // empty: the one the record names
    std::filesystem::path full;     // as in RunOptions
    std::filesystem::path out;
    std::filesystem::path save_hand;  // a CSV file for the recorded hand; empty: none
    bool fast = false;                // as fast as it goes; else at the pace it was recorded
    bool show = false;                // then shown, in a headset or in a window
    bool window = false;              // in a window, though there is a headset
    std::optional<double> at_s{};     // it begins there and stands still
    std::filesystem::path ghost;      // with it: another attempt's, whose needle is shown too; empty: none
};

// 0 when every recorded hash is met, 1 when not. Throws patient::DataError.
int replay(const ReplayOptions&);

}  // namespace stylet::trainer
