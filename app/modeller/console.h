// What the modeller's commands share: a progress bar, and the patient that the command line names.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "patient/patient.h"

namespace stylet::modeller {

// A bar on stderr: redrawn in place on a terminal, one line per stage elsewhere.
std::function<void(std::string_view stage, double fraction)> progressBar(std::string title);

// tissue/ptcd.toml of assetsFolder().
patient::TissueDefaults tissueDefaults();

patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads);

}  // namespace stylet::modeller
