// The study: paths planned in the reference, a needle down each in both patients, a result for each path. The
// unit of work is a block of one pair's paths; what comes of a path depends on nothing but the pair, the path
// and the settings, so blocks may be spread over threads and machines as one likes.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "app/study/statistics.h"

namespace stylet::study {

struct PlanRequest {
    double skin_spacing_m = 0.0, target_spacing_m = 0.0;  // 0: every voxel
    int breaths = 0;  // rate the paths anew in so many phases of a breath: 5 or more, or none
    bool skip = true;
    int threads = 2;
};

struct PairPlan {
    patient::PlanResult result;
    std::vector<double> worst_quality;  // of each path over the breath's phases; empty where not asked for
};

PairPlan planPair(const Pair&, const PlanRequest& = {});

struct RunSettings {
    SteeringSettings steering;
    MeasureSettings measure;
    int threads = 2;
};

inline constexpr std::size_t kBlock = 256;  // paths

// One block, on the caller's thread.
std::vector<PathResult> runBlock(const PreparedPair&, std::span<const patient::PlannedPath>,
                                 const RunSettings&);
// All of them, block by block on `settings.threads` threads; a result for each path, in their order.
std::vector<PathResult> runPaths(const PreparedPair&, std::span<const patient::PlannedPath>,
                                 const RunSettings&);

}  // namespace stylet::study
