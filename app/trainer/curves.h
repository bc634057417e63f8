// `stylet curves`: pictures of what a force table feels like.
#pragma once

#include <filesystem>

namespace stylet::trainer {

struct CurvesOptions {
    std::filesystem::path table;  // TOML with [[tissue]] and [thresholds]; empty: the shipped one
    std::filesystem::path out;
};

// Writes tissues.png and two-fasciae.png. The exit status of the command. Throws patient::DataError.
int curves(const CurvesOptions&);

}  // namespace stylet::trainer
