// `stylet-model import`: a patient package from a hospital's CT and its segmentation.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/import_image.h"
#include "app/modeller/import_map.h"
#include "patient/patient.h"

namespace stylet::modeller {

// What became of one id of the source, measured on the source's own grid.
struct SourceLabel {
    int id = 0;
    std::string target;  // "unsegmented" where thresholds decide
    double volume_ml = 0.0, mean_hu = 0.0;
};

struct ImportSettings {
    std::filesystem::path ct, labels, map;  // DICOM folder or NIfTI; NIfTI; CSV
    std::string series;                     // UID, where the CT's folder holds several
    bool grow_ducts = false;
    double spacing_m = 0.001;
    std::string reference_phase = "inhale";  // "inhale", "exhale" or "v=X": the breath the scan was taken in
    patient::TissueDefaults defaults;        // force table; thresholds are replaced by this CT's own
    ReaderLimits reader;
    std::function<void(std::string_view stage)> progress;       // called as each stage begins
    std::function<void(const std::vector<SourceLabel>&)> list;  // called before an unmapped id is refused
};

struct Imported {
    patient::Package package;
    std::vector<SourceLabel> sources;
    std::vector<std::string> notes;  // one line each: what was found, made or left out
};

// v of "inhale", "exhale" or "v=X", X from 0 to 1. Throws ImportError.
double referenceBreath(const std::string& phase);

// Every id of the source, whether mapped or not, with its volume and mean. `target` of an unmapped id is
// empty.
std::vector<SourceLabel> listSources(const patient::CtVolume& ct, const patient::Volume<std::int16_t>& labels,
                                     const LabelMap&);

// Everything that follows the reading: crop, body, skin, fascia, ducts, thresholds, breathing.
// `labels` holds nothing below 0, as readImage sees to. Throws ImportError where an id is unmapped, nothing
// is liver, or the package would have more voxels than patient::loadPackage takes.
Imported buildPatient(const patient::CtVolume& ct, const patient::Volume<std::int16_t>& labels,
                      const LabelMap&, const ImportSettings&);

// Reads the files (in a child process) and builds.
Imported importPatient(const ImportSettings&);

}  // namespace stylet::modeller
