// The study as one self-contained HTML page, compared with the paper's numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/report/page.h"
#include "app/study/facts.h"
#include "app/study/statistics.h"

namespace stylet::study {

struct ReportedPair {
    std::string name;
    PairFacts facts;
    PlanFacts plan;
    std::vector<PathResult> results;
    std::vector<double> clearance;      // C3 of each path
    std::vector<std::uint8_t> picture;  // PNG of the planned paths; may be empty
    Summary summary, without_bone;      // of all paths; of the paths that meet no bone
};

struct ReportedStudy {
    RunFacts run;
    std::vector<ReportedPair> pairs;
    Summary all, without_bone;
};

// Calls `use` for all patients together, then for each patient, with both summaries.
template <typename Use>
void forEachSummary(const ReportedStudy& study, const Use& use) {
    use("all", study.all, study.without_bone);
    for (const ReportedPair& pair : study.pairs)
        use(pair.name, pair.summary, pair.without_bone);
}

// Reads the outputs of plan and run from OUT. Throws DataError.
ReportedStudy readStudy(const std::filesystem::path& out);

std::string studyPage(const ReportedStudy&);

}  // namespace stylet::study
