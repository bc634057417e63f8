// `stylet palpate`: stiffness of the right flank under a finger, as a picture and a table.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct PalpateOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;
    bool breathing = false;  // false: breath held at end-exhale
    std::filesystem::path out;
};

// Writes palpation.png and palpation.csv into `out`. Returns the exit status.
int palpate(const PalpateOptions&);

}  // namespace stylet::trainer
