// `stylet looks`: writes pictures of a patient as a headset shows them.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct LooksOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // voxel size of a generated reference patient
    int pixels = 640;         // width and height of an eye's picture
    std::filesystem::path out;
};

// Writes looks.png (left and right eye of each look, and a file for each) and classes.png (the transfer
// function of the forces over histogram and slice). Returns the exit status. Throws DataError.
int looks(const LooksOptions&);

}  // namespace stylet::trainer
