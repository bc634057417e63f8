#include "app/study/study.h"
#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace stylet::study {

using patient::PlannedPath;

namespace {

// The breathing state at `count` times, equally spaced over one cycle.
std::vector<patient::Surrogate> breathingPhases(const patient::Package& package, int count) {
    patient::BreathPlan plan;
    plan.rhythm = package.signal;
    patient::BreathingState state;
    const int cycle = int(std::lround(package.signal.period_s / kTick_s));
    std::vector<patient::Surrogate> breaths;
    for (int tick = 0; tick < cycle; ++tick) {
        if (tick == int(std::int64_t(cycle) * std::int64_t(breaths.size()) / count))
            breaths.push_back(patient::surrogateAt(state, plan, kTick_s));
        patient::stepBreathing(state, plan, kTick_s);
    }
    return breaths;
}

PathResult emptyResult() {
    PathResult r;
    r.sampled = r.exact = {kNone, kNone, kNone, kNone};
    r.max_outside_n = kNone;
    r.event_m.fill(kNone);
    return r;
}

}  // namespace

PairPlan planPair(const Pair& pair, const PlanRequest& request) {
    const patient::Patient reference(pair.reference);
    patient::PlanSettings settings = patient::studyPlanSettings(reference);
    settings.skin_spacing_m = request.skin_spacing_m;
    settings.target_spacing_m = request.target_spacing_m;
    settings.skip = request.skip;
    settings.threads = request.threads;
    PairPlan plan{patient::planPaths(reference, settings), {}};
    if (request.breaths > 0)
        plan.worst_quality = patient::worstQualities(reference, settings, plan.result.paths,
                                                     breathingPhases(pair.reference, request.breaths));
    return plan;
}

std::vector<PathResult> runBlock(const PreparedPair& pair, std::span<const PlannedPath> paths,
                                 const RunSettings& settings) {
    Steering steering(pair, settings.steering);
    std::vector<PathResult> results;
    for (const PlannedPath& path : paths) {
        const SteeringResult* const steered = steering.steer(path);
        results.push_back(steered ? measure(*steered, settings.measure) : emptyResult());
    }
    return results;
}

std::vector<PathResult> runPaths(const PreparedPair& pair, std::span<const PlannedPath> paths,
                                 const RunSettings& settings) {
    std::vector<PathResult> results(paths.size());
    parallelFor(settings.threads, blockCount(paths.size()), [&](std::size_t block) {
        const std::size_t begin = block * kBlock, count = std::min(kBlock, paths.size() - begin);
        const std::vector<PathResult> part = runBlock(pair, paths.subspan(begin, count), settings);
        std::copy(part.begin(), part.end(), results.begin() + std::ptrdiff_t(begin));
    });
    return results;
}

}  // namespace stylet::study
