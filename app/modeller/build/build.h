// `stylet-model build`: a patient package from a CT alone, in stages that a person can review and correct.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/check_package.h"
#include "app/modeller/import_image.h"
#include "patient/patient.h"

namespace stylet::modeller {

struct BuildSettings {
    std::filesystem::path ct;                    // DICOM folder or NIfTI file
    std::string series;                          // UID, where that folder holds several
    std::filesystem::path stages;                // folder of the stages: made, or gone on from
    std::vector<std::filesystem::path> atlases;  // packages; none: reference patients of kAtlasSeeds
    double spacing_m = 0.001;
    bool virtual_ducts = false;              // grown beside portal branches where none are to be seen
    std::string reference_phase = "inhale";  // the breath the scan was taken in, as for an import
    std::string name = "built patient", licence = "unknown: ask whoever gave you the images";
    patient::TissueDefaults defaults;  // force table; thresholds are replaced by this CT's own
    ReaderLimits reader;
    std::function<void(std::string_view stage, double fraction)> progress;
    std::function<bool()> cancelled;  // asked between stages: true ends it
};

// Of the reference patients that stand in where no atlas is named. No report is made on them.
inline constexpr std::uint64_t kAtlasSeeds[] = {101, 102, 103, 104};

struct StageReport {
    std::string name;
    double seconds = 0.0;
    bool kept = false;       // from an earlier run
    bool corrected = false;  // by a person
    std::vector<std::string> notes;
};

struct Built {
    patient::Package package;
    std::vector<StageReport> stages;
    std::vector<Finding> findings;  // checkPackage's
};

// In their order.
std::vector<std::string> stageNames();

// Runs every stage whose inputs are not those of its last run. Throws ImportError, patient::DataError, or
// std::runtime_error where it was cancelled; what was finished stands.
Built build(const BuildSettings&);

// Puts a person's labels in a stage's place. `labels` lies on the grid of the stages' ct.nii.gz and holds ids
// of the stage's colour table. Throws ImportError or patient::DataError.
void correctStage(const std::filesystem::path& stages, const std::string& name,
                  const std::filesystem::path& labels);

}  // namespace stylet::modeller
