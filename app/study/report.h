// The study as one self-contained page, beside the paper's numbers.
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
    std::vector<std::uint8_t> picture;  // of the planned paths, PNG; may be empty
    Summary summary, without_bone;      // of all paths, of those that meet no bone
};

struct ReportedStudy {
    RunFacts run;
    std::vector<ReportedPair> pairs;
    Summary all, without_bone;
};

// All first, then each patient, with the summary of the paths that meet no bone.
template <typename Use>
void forAll(const ReportedStudy& study, const Use& use) {
    use("all", study.all, study.without_bone);
    for (const ReportedPair& pair : study.pairs)
        use(pair.name, pair.summary, pair.without_bone);
}

// What plan and run left in OUT. Throws patient::DataError.
ReportedStudy readStudy(const std::filesystem::path& out);

std::string studyPage(const ReportedStudy&);

}  // namespace stylet::study
