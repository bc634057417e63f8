// The commands of stylet-study. They say what they do on stdout and throw patient::DataError.
#pragma once

#include <filesystem>

#include "app/study/study.h"

namespace stylet::study {

struct StudyOptions {
    std::filesystem::path study, out;  // the study file; the folder of what comes of it
    PlanRequest plan;
    RunSettings run;
    FoundLabels labels = FoundLabels::partial;
    std::size_t most_paths = 0;     // the best so many of a pair's; 0: all
    std::size_t sampled_paths = 0;  // the forces at every sample of so many of each pair's best
};

// OUT/<pair>/paths.json (as a package has it), plan.csv, plan.json.
void runPlan(const StudyOptions&);
// OUT/<pair>/paths.csv, samples.csv where asked for, OUT/summary.json. Plans first where a pair's paths.json
// is missing or of another patient or planner.
void runStudy(const StudyOptions&);

}  // namespace stylet::study
