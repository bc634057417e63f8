// The study on disk: one CSV row per path, one row per sample if requested, and summaries as JSON. Numbers
// are written with the fewest digits that restore the same bits. Missing values are empty in CSV and null
// in JSON.
#pragma once

#include <filesystem>
#include <span>

#include "app/study/study.h"

namespace stylet::study {

struct PairFindings {
    std::string name;
    double reference_share = 0.0;  // share of the body that has labels in the reference
    std::vector<patient::PlannedPath> paths;
    std::vector<PathResult> results;  // one per path
    Summary summary;
};

// All throw DataError if a file cannot be written.
void writePlanTable(const std::filesystem::path& csv, const PairPlan&);
// `implausible`: verdicts that were overruled.
void writePlanSummary(const std::filesystem::path& json, const PairPlan&, const PlanRequest&,
                      const std::vector<std::string>& implausible = {});
void writePathTable(const std::filesystem::path& csv, const PairFindings&);
// Columns: path, depth from the entry, both forces. Steers the paths again.
void writeSampleTable(const std::filesystem::path& csv, const PreparedPair&,
                      std::span<const patient::PlannedPath>, const SteeringSettings&);
void writeSummary(const std::filesystem::path& json, std::span<const PairFindings>, const RunSettings&,
                  FoundLabels);

}  // namespace stylet::study
