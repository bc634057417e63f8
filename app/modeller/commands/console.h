// Shared by the commands of stylet-model: progress, summaries, and reference patients named on the command
// line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "patient/patient.h"

namespace stylet::modeller {

// Prints the name of a stage on stderr, after the seconds since this call.
std::function<void(std::string_view stage)> timedProgress();

// A progress bar on stderr: redrawn in place on a terminal, otherwise one line per stage.
std::function<void(std::string_view stage, double fraction)> progressBar(std::string title);

// Loads tissue/ptcd.toml from assetsFolder().
patient::TissueDefaults tissueDefaults();

// Prints the thresholds of a package, its folder and its size, without a line ending.
void printPackage(const patient::Package&, const std::filesystem::path& folder);

patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads);

}  // namespace stylet::modeller
