// Shared by the commands of stylet-model: progress, summaries, and reference patients named on the command
// line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/check/check_package.h"
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

// Prints the findings and stores them as the verdict of the package in `folder`, in a file beside it. A
// folder that cannot be written is only reported. Returns false if the package is refused.
bool printVerdict(const patient::Package&, const std::filesystem::path& folder, const std::vector<Finding>&);

// Throws DataError if a package cannot be saved in `out`, or if it would replace one of the inputs. Inputs
// may be empty. Called before the work begins.
void checkOut(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs = {});

// `variants`: names from patient::synth::listVariants().
patient::Package referencePatient(std::uint64_t seed, double spacing_mm, int threads,
                                  const std::vector<std::string>& variants = {});

}  // namespace stylet::modeller
