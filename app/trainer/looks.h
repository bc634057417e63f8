// `stylet looks`: what a headset shows of a patient, as pictures.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct LooksOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // of a reference patient made here
    int pixels = 640;         // of an eye's picture, along either side
    std::filesystem::path out;
};

// looks.png, left and right eye of each look, with a file for each; and classes.png, the transfer function of
// the forces over histogram and slice. The exit status of the command. Throws patient::DataError.
int looks(const LooksOptions&);

}  // namespace stylet::trainer
