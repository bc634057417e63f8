// What the report says of a pair, and what the run leaves for it: OUT/<pair>/pair.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/study/study.h"

namespace stylet::study {

struct LabelFacts {
    std::string name, provenance;
    patient::Tissue tissue = patient::Tissue::soft;
    std::size_t voxels = 0;
    bool counts = true;  // in this study
};

struct PackageFacts {
    std::string name, licence, provenance;
    double labelled_share = 0.0;     // of the body
    std::vector<LabelFacts> labels;  // those that have voxels
    patient::Thresholds thresholds;
};

struct PairFacts {
    PackageFacts reference, found;
    patient::Vec3 spacing_m{0.0};
    patient::Index3 dims{0};
    patient::TissueTable tissues{};
    std::string own_table;  // the file's name; empty: the reference's own
    std::uint64_t run = 0;  // runDigest
    std::size_t paths = 0;
};

PairFacts factsOf(const Pair&, const std::string& own_table);

// Both throw patient::DataError.
void writeFacts(const std::filesystem::path& json, const PairFacts&);
PairFacts readFacts(const std::filesystem::path& json);

// plan.json, as the report needs it.
struct PlanFacts {
    double skin_spacing_m = 0.0, target_spacing_m = 0.0;  // as asked for: 0 is every voxel
    int breaths = 0;
    std::size_t candidates = 0, skipped = 0, blocked = 0, too_long = 0, poor = 0, kept = 0;
    std::vector<std::size_t> c3, c4, quality;  // of the kept paths, in equal bins of [0, 1]
    std::vector<std::size_t> worst_quality;    // over the breath's phases; empty where they were not rated
};
PlanFacts readPlanFacts(const std::filesystem::path& json);  // throws patient::DataError

// summary.json: the pairs, in their order, and what the forces were worked out with.
struct RunFacts {
    std::vector<std::string> names;
    RunSettings settings;
    FoundLabels labels = FoundLabels::partial;
};
RunFacts readRunFacts(const std::filesystem::path& json);  // throws patient::DataError

}  // namespace stylet::study
