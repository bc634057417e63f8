// `stylet palpate`: the right flank under the finger, as a picture and as numbers.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct PalpateOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;
    bool breathing = false;  // else held at end-exhale
    std::filesystem::path out;
};

// Writes palpation.png and palpation.csv into `out`; the exit code.
int palpate(const PalpateOptions&);

}  // namespace stylet::trainer
