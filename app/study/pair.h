// What a study compares: a reference package, and a package built from the same CT without its labels.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/patient.h"

namespace stylet::study {

// A folder of its own in OUT, beside what is of all pairs.
bool isPairName(const std::string&);

struct PairFiles {
    std::string name;
    std::filesystem::path reference, found;  // package folders
};

// A TOML file; folders are relative to it, and no two pairs have one name:
//   tissue = "table.toml"     # optional: the force table of both, as assets/tissue/ptcd.toml
//   [[pair]]
//   name = "seed 1"           # optional: else the reference's folder
//   reference = "truth/seed1"
//   found = "built/seed1"
struct StudyFile {
    std::vector<PairFiles> pairs;
    std::optional<std::filesystem::path> tissue;
};
// Both throw patient::DataError.
StudyFile readStudyFile(const std::filesystem::path& toml);
StudyFile parseStudyFile(std::string_view text, const std::filesystem::path& file);

// Which of the found labels count.
enum class FoundLabels {
    partial,  // the paper's partial segmentation; elsewhere thresholds decide over the CT as it was taken
    all       // all, on the CT as the build has cut it to the body: the patient that is trained on
};

// Both on the reference's voxels, with its force table and its breath: what differs is the segmentation, and
// the thresholds, which are part of it.
struct Pair {
    std::string name;
    patient::Package reference, found;
    FoundLabels labels = FoundLabels::partial;
    std::uint64_t reference_digest = 0;  // as its folder has it: an own force table plans no other paths
    double reference_share = 0.0;        // of the body that has labels in the reference
};

// Throws patient::DataError where the two are not on the same CT: of the found package's voxels each must be
// the reference's, or air that a build put outside the body. Or where labels share their provenance, or the
// reference was among the found one's atlases.
Pair makePair(const PairFiles&, patient::Package reference, patient::Package found, FoundLabels,
              const patient::TissueTable* own_table = nullptr);
Pair loadPair(const PairFiles&, FoundLabels, const patient::TissueTable* own_table = nullptr);

// Ready for many needles. Keeps a reference to the pair.
struct PreparedPair {
    explicit PreparedPair(const Pair&);
    const Pair& pair;
    patient::Patient full, partial;
    patient::TissueMap full_map, partial_map;
};

}  // namespace stylet::study
