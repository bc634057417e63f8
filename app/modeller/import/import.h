// `stylet-model import`: makes a patient package from a hospital's CT and its segmentation.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/image/import_image.h"
#include "app/modeller/import/import_map.h"
#include "patient/patient.h"

namespace stylet::modeller {

// One id of the source segmentation and its mapping, measured on the source's own grid.
struct SourceLabel {
    int id = 0;
    std::string target;  // "unsegmented": thresholds decide
    double volume_ml = 0.0, mean_hu = 0.0;
};

struct ImportSettings {
    std::filesystem::path ct, labels, map;  // DICOM folder or NIfTI; NIfTI; CSV
    std::string series;                     // series UID, if the CT's folder contains several
    bool grow_ducts = false;
    double spacing_m = 0.001;
    std::string reference_phase = "inhale";  // "inhale", "exhale" or "v=X": the breathing state of the scan
    patient::TissueDefaults defaults;        // force table; this CT's thresholds replace the defaults
    ReaderLimits reader;
    std::function<void(std::string_view stage)> progress;       // called when a stage begins
    std::function<void(const std::vector<SourceLabel>&)> list;  // called before an unmapped id is refused
};

struct ImportResult {
    patient::Package package;
    std::vector<SourceLabel> sources;
    std::vector<std::string> notes;  // one line each: findings, additions, omissions
};

// Returns v for "inhale", "exhale" or "v=X", with X from 0 to 1. Throws ImportError.
double parseReferencePhase(const std::string& phase);

// Lists every id of the source, mapped or not, with volume and mean HU. `target` is empty for an unmapped
// id.
std::vector<SourceLabel> listSources(const CtVolume& ct, const Volume<std::int16_t>& labels, const LabelMap&);

// Performs all steps after reading: crop, body, skin, fascia, thresholds, costal cartilage, muscle beside
// bones, ducts, breathing. `labels` must not contain negative values; readImage() guarantees this. Throws
// ImportError if an id is unmapped, if there is no liver, or if the package would have more voxels than
// patient::loadPackage accepts.
ImportResult buildPatient(const CtVolume& ct, const Volume<std::int16_t>& labels, const LabelMap&,
                          const ImportSettings&);

// Reads the files in a child process and builds the patient.
ImportResult importPatient(const ImportSettings&);

}  // namespace stylet::modeller
