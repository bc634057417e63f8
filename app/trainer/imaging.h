// `stylet imaging`: what ultrasound and X-ray show of a patient, as pictures.
#pragma once

#include <cstdint>
#include <filesystem>

namespace stylet::trainer {

struct ImagingOptions {
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // of a reference patient made here
    std::filesystem::path out;
};

// ultrasound.png and fluoroscopy.png, sheets of the machines' screens, with a file for each picture. The exit
// status of the command. Throws patient::DataError.
int imaging(const ImagingOptions&);

}  // namespace stylet::trainer
