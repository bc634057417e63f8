// `stylet curves`: plots of a force table.
#pragma once

#include <filesystem>

namespace stylet::trainer {

struct CurvesOptions {
    std::filesystem::path table;  // TOML with [[tissue]] and [thresholds]; empty: the installed table
    std::filesystem::path out;
};

// Writes tissues.png and two-fasciae.png. Returns the exit status. Throws DataError.
int curves(const CurvesOptions&);

}  // namespace stylet::trainer
