// Reference paths: straight lines from the skin to a bile duct's centre line, rated by four criteria.
// Source: Mastmeyer et al. 2017, Eq. 9, after Baegert et al. 2007.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "patient/package.h"

namespace stylet::patient {

struct PlanSettings {
    Surrogate breath;                 // the (held) breath in which the path is straight and is judged
    double skin_spacing_m = 0.008;    // of the set of skin voxels; 0: every one
    double target_spacing_m = 0.004;  // thinning of the duct's centre line; 0: none
    double max_length_m = 0.090;      // C2
    double min_quality = 0.4;
    double near_target_m = 0.010;  // within this of the duct's wall vessels count for C1 only
    // Pairs that cannot be their skin voxel's best path are not walked; the paths are the same. Only in the
    // breath of the CT, where paths are straight in the reference.
    bool skip = true;
    int threads = 2;
};

// Every skin voxel of the access area against every voxel of the duct's centre line, in the breath of the CT.
PlanSettings studyPlan(const Patient&);

struct PlannedPath {
    Vec3 entry_m{0.0}, target_m{0.0};                      // ends in the deformed patient at `breath`
    Vec3 entry_reference_m{0.0}, target_reference_m{0.0};  // the same ends in the reference
    Surrogate breath;
    double length_m = 0.0;
    double clearance_score = 0.0;  // C3 in [0, 1]
    double target_score = 0.0;     // C4 in [0, 1]
    double quality = 0.0;          // (C3 + C4) / 2
};

// Counts up whenever planPaths finds or rates other paths in the same patient: stored ones are stale then.
inline constexpr int kPlannerVersion = 4;

struct PlanResult {
    std::vector<PlannedPath> paths;  // the best path of each skin voxel, best first
    std::size_t candidates = 0, skipped = 0, rejected_blocked = 0, rejected_long = 0, rejected_quality = 0;
};

// The skin in the access area (right flank, between the axillary lines, at liver height) against the duct's
// centre line; each path between two ribs, the hand behind it above the table. See patient/README.md.
PlanResult planPaths(const Patient&, const PlanSettings&,
                     const std::function<void(double fraction)>& progress = {});

// Length, scores and quality of a path whose ends and breath are set; false where the planner would not have
// kept it, and then what it did not come to is 0.
bool ratePath(const Patient&, const PlanSettings&, PlannedPath&);

// The worst quality of each path's tissue ends over breaths of the patient: with the ends where a breath
// takes them, 0 where the planner would not keep the path then.
std::vector<double> worstQualities(const Patient&, const PlanSettings&, const std::vector<PlannedPath>&,
                                   const std::vector<Surrogate>& breaths);

inline constexpr std::size_t kMaxStoredPaths = 100'000;
// What paths.json holds: paths, and what they were planned on and by.
struct StoredPaths {
    std::uint64_t patient_digest = 0;  // digest(Package)
    int planner_version = 0;
    std::vector<PlannedPath> paths;
};

void savePaths(const StoredPaths&, const std::filesystem::path& json);
StoredPaths loadPaths(const std::filesystem::path& json);  // throws DataError

}  // namespace stylet::patient
