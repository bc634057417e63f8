// `stylet looks`: writes pictures of a patient as seen in a headset.
#pragma once

#include <filesystem>

#include "app/trainer/stores/patient_source.h"

namespace stylet::trainer {

struct LooksOptions {
    PatientOptions source;
    int pixels = 640;  // width and height of an eye's picture
    std::filesystem::path out;
};

// Writes looks.png (left and right eye of each look), a file for each look, and classes.png (the transfer
// function of the forces over histogram and slice). Returns the exit status. Throws DataError,
// EnvironmentError.
int looks(const LooksOptions&);

}  // namespace stylet::trainer
