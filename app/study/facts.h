// Facts about a pair that the run writes to OUT/<pair>/pair.json and the report shows.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/study/study.h"

namespace stylet::study {

struct LabelFacts {
    std::uint8_t id = 0;
    std::string name, provenance;
    patient::Tissue tissue = patient::Tissue::soft;
    std::size_t voxels = 0;
    bool counts = true;  // the study uses the label
};

struct PackageFacts {
    std::string name, licence, provenance;
    double labelled_share = 0.0;     // share of the body that has labels
    std::vector<LabelFacts> labels;  // only labels that have voxels
    patient::Thresholds thresholds;
};

struct PairFacts {
    PackageFacts reference, found;
    Vec3 spacing_m{0.0};
    Index3 dims{0};
    patient::TissueTable tissues{};
    std::string own_table;                 // file name of the study's force table; empty: the reference's
    std::vector<std::string> implausible;  // overruled verdicts, as in Pair
    std::uint64_t run = 0;                 // runDigest
    std::size_t paths = 0;
};

PairFacts makePairFacts(const Pair&, const std::string& own_table);

// Both throw DataError.
void writeFacts(const std::filesystem::path& json, const PairFacts&);
PairFacts readFacts(const std::filesystem::path& json);

// The contents of plan.json that the report needs.
struct PlanFacts {
    double skin_spacing_m = 0.0, target_spacing_m = 0.0;  // as requested; 0: every voxel
    int breaths = 0;
    std::size_t candidates = 0, skipped = 0, blocked = 0, too_long = 0, poor = 0, kept = 0;
    std::vector<std::size_t> c3, c4, quality;  // histograms over the kept paths, equal bins of [0, 1]
    std::vector<std::size_t> worst_quality;    // worst quality over the breathing phases; empty if not rated
};
PlanFacts readPlanFacts(const std::filesystem::path& json);  // throws DataError

// The contents of summary.json: the pairs in order, and the settings of the force computation.
struct RunFacts {
    std::vector<std::string> names;
    RunSettings settings;
    FoundLabels labels = FoundLabels::partial;
};
RunFacts readRunFacts(const std::filesystem::path& json);  // throws DataError

}  // namespace stylet::study
