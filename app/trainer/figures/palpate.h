// `stylet palpate`: measures the stiffness of the right flank under a finger; writes a picture and a table.
#pragma once

#include <filesystem>

#include "app/trainer/stores/patient_source.h"

namespace stylet::trainer {

struct PalpateOptions {
    PatientOptions source;
    bool breathing = false;  // false: breath held at end-exhale
    std::filesystem::path out;
};

// Writes palpation.png and palpation.csv into `out`. Returns the exit status.
int palpate(const PalpateOptions&);

}  // namespace stylet::trainer
