// The study: plan paths in the reference, steer a needle along each in both patients, and compute a result
// per path. The unit of work is a block of one pair's paths. A path's result depends only on the pair, the
// path and the settings, so blocks may be distributed over threads and machines.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "app/study/statistics.h"

namespace stylet::study {

struct PlanRequest {
    double skin_spacing_m = 0.0, target_spacing_m = 0.0;  // 0: every voxel
    int breaths = 0;  // rate the paths again in this many breathing phases: 5 or more, or 0 for none
    bool skip = true;
    int threads = 2;
};

struct PairPlan {
    patient::PlanResult result;
    std::vector<double> worst_quality;  // per path, over the breathing phases; empty if not requested
};

PairPlan planPair(const Pair&, const PlanRequest& = {});

struct RunSettings {
    SteeringSettings steering;
    MeasureSettings measure;
    int threads = 2;
};

inline constexpr std::size_t kBlock = 256;  // paths per block
constexpr std::size_t blockCount(std::size_t paths) {
    return (paths + kBlock - 1) / kBlock;
}

// Runs one block on the caller's thread.
std::vector<PathResult> runBlock(const PreparedPair&, std::span<const patient::PlannedPath>,
                                 const RunSettings&);
// Runs all blocks on `settings.threads` threads. Returns one result per path, in order.
std::vector<PathResult> runPaths(const PreparedPair&, std::span<const patient::PlannedPath>,
                                 const RunSettings&);

}  // namespace stylet::study
