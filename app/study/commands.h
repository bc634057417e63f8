// The commands of stylet-study. Each prints its progress on stdout and throws DataError. With
// several ranks, every rank calls the same command and does its share of the work.
#pragma once

#include <filesystem>

#include "app/study/ranks.h"
#include "app/study/study.h"

namespace stylet::study {

struct StudyOptions {
    std::filesystem::path study, out;  // study file; output folder
    PlanRequest plan;
    // The user set the plan request explicitly: paths planned with another request are planned again, not
    // reused.
    bool plan_is_explicit = false;
    RunSettings run;
    FoundLabels labels = FoundLabels::all;
    bool accept_implausible = false;  // use packages that `stylet-model check` refused
    std::size_t max_paths = 0;        // the best N paths of each pair; 0: all
    std::size_t sampled_paths = 0;    // write the force at every sample for the best N paths of each pair
};

// Writes OUT/<pair>/paths.json (same format as in a package), plan.csv, plan.json and paths.png.
void runPlan(const StudyOptions&, const Ranks& = {});
// Writes OUT/<pair>/paths.csv, samples.csv (if requested) and OUT/summary.json, plus the report's inputs
// OUT/<pair>/pair.json and OUT/<pair>/blocks. Plans first if a pair's paths.json is missing or belongs to
// another patient, planner or request. Resumes an interrupted run: finished blocks of paths are not
// recomputed.
void runStudy(const StudyOptions&, const Ranks& = {});
// Writes OUT/report.html from the outputs of the other commands. Returns its path.
std::filesystem::path writeReport(const std::filesystem::path& out);

}  // namespace stylet::study
