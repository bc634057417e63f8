// `stylet replay`: recomputes a record and, with --show, displays it.
#pragma once

#include <filesystem>
#include <optional>

namespace stylet::trainer {

struct ReplayOptions {
    std::filesystem::path record;   // the record's folder, or the attempt's folder that contains it
    std::filesystem::path patient;  // empty: the patient that the record names
    std::filesystem::path full;     // see AttemptConfig
    std::filesystem::path out;
    std::filesystem::path save_hand;  // CSV file for the recorded input; empty: none
    bool fast = false;                // as fast as possible; otherwise at the recorded pace
    bool show = false;                // afterwards, show it in a headset or a window
    bool window = false;              // use a window even if there is a headset
    std::optional<double> at_s{};     // start of the display, paused
    std::filesystem::path ghost;      // with `show`: another attempt, whose needle is also drawn; empty: none
};

// Returns 0 if every recorded hash, every stored sample and the result match, else 1. A finished attempt has
// a sample for every tick. The last samples of an attempt that was cut short may be missing. Throws
// DataError.
int replay(const ReplayOptions&);

}  // namespace stylet::trainer
