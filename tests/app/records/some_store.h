// Attempts and indices of stores, for their tests.
#pragma once

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::test {

inline records::AttemptInfo someAttemptInfo(const std::string& trainee = "T-01") {
    records::AttemptInfo info{trainee, "falcon", "reference patient, seed 1", "demo", "practice", "1.2.3"};
    info.patient_digest = 0xfedcba9876543210ull;
    info.seed = std::numeric_limits<std::uint64_t>::max();
    info.device_gain = 0.25;
    info.registration_rms_m = 0.0011;
    return info;
}

// Deletes the index of a store that is not open.
inline void deleteIndex(const std::filesystem::path& store) {
    for (const char* name : {"store.sqlite", "store.sqlite-wal", "store.sqlite-shm"})
        std::filesystem::remove(store / name);
}

inline bool contains(const std::vector<std::string>& lines, const std::string& text) {
    return std::ranges::any_of(lines,
                               [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace stylet::test
