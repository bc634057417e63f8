// `stylet imaging`: writes ultrasound and X-ray pictures of a patient.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct ImagingOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // voxel size of a generated reference patient
    std::filesystem::path out;
};

// Writes ultrasound.png and fluoroscopy.png, contact sheets of the two screens, and a file for each
// picture. Returns the exit status. Throws DataError.
int imaging(const ImagingOptions&);

}  // namespace stylet::trainer
