// Shared by the commands of stylet-model: a progress bar, and reference patients named on the command line.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "patient/patient.h"

namespace stylet::modeller {

// A progress bar on stderr: redrawn in place on a terminal, otherwise one line per stage.
std::function<void(std::string_view stage, double fraction)> progressBar(std::string title);

// Loads tissue/ptcd.toml from assetsFolder().
patient::TissueDefaults tissueDefaults();

patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads);

}  // namespace stylet::modeller
