// The commands of stylet-study. They say what they do on stdout and throw patient::DataError. With several
// ranks each calls the same command and does its share.
#pragma once

#include <filesystem>

#include "app/study/ranks.h"
#include "app/study/study.h"

namespace stylet::study {

struct StudyOptions {
    std::filesystem::path study, out;  // the study file; the folder of what comes of it
    PlanRequest plan;
    // The request was made in so many words: paths planned otherwise are planned anew, not taken.
    bool plan_is_asked = false;
    RunSettings run;
    FoundLabels labels = FoundLabels::partial;
    std::size_t most_paths = 0;     // the best so many of a pair's; 0: all
    std::size_t sampled_paths = 0;  // the forces at every sample of so many of each pair's best
};

// OUT/<pair>/paths.json (as a package has it), plan.csv, plan.json, paths.png.
void runPlan(const StudyOptions&, const Ranks& = {});
// OUT/<pair>/paths.csv, samples.csv where asked for, OUT/summary.json, and what the report needs besides:
// OUT/<pair>/pair.json, blocks. Plans first where a pair's paths.json is missing or of another patient,
// planner or request. A run that did not come to its end goes on: no block of paths that it left is worked
// out again.
void runStudy(const StudyOptions&, const Ranks& = {});
// OUT/report.html from what the others left; its file.
std::filesystem::path writeReport(const std::filesystem::path& out);

}  // namespace stylet::study
