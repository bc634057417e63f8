// `stylet-model build`: makes a patient package from a CT alone, in stages that a person can review and
// correct.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/check/check_package.h"
#include "app/modeller/image/import_image.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct BuildSettings {
    std::filesystem::path ct;                    // DICOM folder or NIfTI file
    std::string series;                          // series UID, if the folder contains several
    std::filesystem::path stages;                // folder of the stages; created, or resumed
    std::vector<std::filesystem::path> atlases;  // packages; none: the reference patients of kAtlasSeeds
    double spacing_m = 0.001;
    bool virtual_ducts = false;  // grown beside portal branches if the CT shows no ducts
    bool trust_axes = false;     // accept a scan that looks mirrored, upside down or turned front to back
    std::string reference_phase = "inhale";  // breathing state of the scan, as for an import
    std::string name = "built patient", licence = "unknown: ask whoever gave you the images";
    patient::TissueDefaults defaults;  // force table; this CT's thresholds replace the defaults
    ReaderLimits reader;
    std::function<void(std::string_view stage, double fraction)> progress;
    std::function<bool()> cancelled;  // polled between stages; true cancels the build
};

// Seeds of the reference patients used as default atlases. No accuracy report uses them.
inline constexpr std::uint64_t kAtlasSeeds[] = {101, 102, 103, 104};

struct StageReport {
    std::string name;
    double seconds = 0.0;
    bool reused = false;     // reused from an earlier run
    bool corrected = false;  // by a person
    std::vector<std::string> notes;
};

struct BuildResult {
    patient::Package package;
    std::vector<StageReport> stages;
    std::vector<Finding> findings;  // from checkPackage()
};

// In order of execution.
std::vector<std::string> stageNames();

// Runs every stage whose inputs have changed since its last run. Throws ImportError, DataError, or
// std::runtime_error if cancelled. Finished stages are kept.
BuildResult build(const BuildSettings&);

// Replaces a stage's result with labels edited by a person. `labels` must be on the grid of the stages'
// ct.nii.gz and contain ids of the stage's colour table. Throws ImportError or DataError.
void correctStage(const std::filesystem::path& stages, const std::string& name,
                  const std::filesystem::path& labels);

}  // namespace stylet::modeller
