// `stylet replay`: recomputes a record, and shows it if wanted.
#pragma once

#include <filesystem>
#include <optional>

namespace stylet::trainer {

struct ReplayOptions {
    std::filesystem::path record;   // the record's folder, or the attempt's folder that contains it
    std::filesystem::path patient;  // empty: the one the record names
    std::filesystem::path full;     // see RunOptions
    std::filesystem::path out;
    std::filesystem::path save_hand;  // CSV file for the recorded input; empty: none
    bool fast = false;                // as fast as possible; else at the recorded pace
    bool show = false;                // then show it in a headset or a window
    bool window = false;              // use a window even if there is a headset
    std::optional<double> at_s{};     // start there, paused
    std::filesystem::path ghost;      // with `show`: another attempt whose needle is also shown; empty: none
};

// Returns 0 if every recorded hash and every stored sample matches, else 1. Throws DataError.
int replay(const ReplayOptions&);

}  // namespace stylet::trainer
