// The two packages a study compares: a reference package, and one built from the same CT without its labels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"

namespace stylet::study {

// Returns true if the name can be a folder in OUT and does not clash with the study's own files.
bool isPairName(const std::string&);

struct PairFiles {
    std::string name;
    std::filesystem::path reference, found;  // package folders
};

// A TOML file. Folders are relative to it, and pair names are unique:
//   tissue = "table.toml"     # optional: the force table of both, as assets/tissue/ptcd.toml
//   [[pair]]
//   name = "seed 1"           # optional: else the reference's folder
//   reference = "truth/seed1"
//   found = "built/seed1"
struct StudyFile {
    std::vector<PairFiles> pairs;
    std::optional<std::filesystem::path> tissue;
};
// Both throw DataError.
StudyFile readStudyFile(const std::filesystem::path& toml);
StudyFile parseStudyFile(std::string_view text, const std::filesystem::path& file);

// The labels of the built package that the study uses.
enum class FoundLabels {
    partial,  // the paper's partial segmentation; elsewhere thresholds on the original CT
    all       // all labels, on the CT that the build cropped to the body: the patient used in training
};

// Both packages are on the reference's voxel grid and use its force table and breathing. They differ only
// in the segmentation, which includes the thresholds.
struct Pair {
    std::string name;
    patient::Package reference, found;
    FoundLabels labels = FoundLabels::partial;
    std::uint64_t reference_digest = 0;    // of the package folder; the study's force table changes no paths
    double reference_share = 0.0;          // share of the body that has labels in the reference
    std::vector<std::string> implausible;  // verdicts of `stylet-model check` that were overruled
};

// Throws DataError if the two are not from the same CT: each voxel of the found package must equal
// the reference's, or be air that the build put outside the body. Also throws if labels share their
// provenance, or if the reference was one of the found package's atlases.
Pair makePair(const PairFiles&, patient::Package reference, patient::Package found, FoundLabels,
              const patient::TissueTable* own_table = nullptr);
// Also throws DataError if `stylet-model check` refused one of the packages, unless `accept_implausible`.
Pair loadPair(const PairFiles&, FoundLabels, const patient::TissueTable* own_table = nullptr,
              bool accept_implausible = false);

// A pair prepared for steering many needles. Keeps a reference to the pair.
struct PreparedPair {
    explicit PreparedPair(const Pair&);
    const Pair& pair;
    patient::Patient full, partial;
    patient::TissueMap full_map, partial_map;
};

}  // namespace stylet::study
