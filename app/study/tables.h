// The study on disk: one row a path, a row a sample where asked for, and the summaries as JSON. Numbers are
// as short as brings the same bits back; what there is none of is empty, or null.
#pragma once

#include <filesystem>
#include <span>

#include "app/study/study.h"

namespace stylet::study {

struct PairFindings {
    std::string name;
    double reference_share = 0.0;  // of the body with labels in the reference
    std::vector<patient::PlannedPath> paths;
    std::vector<PathResult> results;  // of each path
    Summary summary;
};

// All throw patient::DataError where a file cannot be written.
void writePlanTable(const std::filesystem::path& csv, const PairPlan&);
void writePlanSummary(const std::filesystem::path& json, const PairPlan&, const PlanRequest&);
void writePathTable(const std::filesystem::path& csv, const PairFindings&);
// path, depth from the entry, both forces; the paths are steered once more.
void writeSampleTable(const std::filesystem::path& csv, const PreparedPair&,
                      std::span<const patient::PlannedPath>, const SteeringSettings&);
void writeSummary(const std::filesystem::path& json, std::span<const PairFindings>, const RunSettings&,
                  FoundLabels);

}  // namespace stylet::study
