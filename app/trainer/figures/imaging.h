// `stylet imaging`: writes ultrasound and X-ray pictures of a patient.
#pragma once

#include <filesystem>

#include "app/trainer/stores/patient_source.h"

namespace stylet::trainer {

struct ImagingOptions {
    PatientOptions source;
    std::filesystem::path out;
};

// Writes ultrasound.png and fluoroscopy.png, contact sheets of the two screens, and a file for each
// picture. Returns the exit status. Throws DataError, EnvironmentError.
int imaging(const ImagingOptions&);

}  // namespace stylet::trainer
