#include "app/modeller/build/path_forces.h"

#include <algorithm>
#include <cmath>

#include "haptics/haptics.h"

namespace stylet::modeller {

using patient::Patient;
using patient::PlannedPath;
using patient::Vec3;

namespace {

constexpr double kStep_m = 20e-6;  // a tick at 20 mm/s
constexpr double kBefore_m = 0.010;

struct OnePath {
    double sum_n2 = 0.0, largest_n = 0.0;
    std::size_t ticks = 0, equal = 0;
};

OnePath walk(const Patient& truth, const Patient& found, const PlannedPath& path) {
    const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
    const double length_m = glm::distance(path.entry_m, path.target_m);
    haptics::NeedleState needles[2];
    haptics::NeedleEvents events;
    OnePath out;
    for (double at_m = -kBefore_m; at_m <= length_m; at_m += kStep_m) {
        const Vec3 tip_m = path.entry_m + at_m * axis;
        haptics::stepNeedle(needles[0], {}, truth, tip_m, axis, path.breath, events);
        haptics::stepNeedle(needles[1], {}, found, tip_m, axis, path.breath, events);
        if (needles[0].phase == haptics::Phase::outside && needles[1].phase == haptics::Phase::outside)
            continue;
        const double error_n = needles[1].force_n - needles[0].force_n;
        ++out.ticks;
        out.equal += error_n == 0.0;
        out.sum_n2 += error_n * error_n;
        out.largest_n = std::max(out.largest_n, std::fabs(error_n));
    }
    return out;
}

}  // namespace

PathForces compareForces(const Patient& truth, const Patient& found, const std::vector<PlannedPath>& paths) {
    std::vector<OnePath> each(paths.size());
    patient::parallelFor(2, paths.size(), [&](std::size_t i) { each[i] = walk(truth, found, paths[i]); });
    PathForces all;
    all.paths = paths.size();
    OnePath sum;
    std::vector<double> rms_n;
    for (const OnePath& one : each) {
        sum.sum_n2 += one.sum_n2;
        sum.ticks += one.ticks;
        sum.equal += one.equal;
        sum.largest_n = std::max(sum.largest_n, one.largest_n);
        if (one.ticks > 0) rms_n.push_back(std::sqrt(one.sum_n2 / double(one.ticks)));
    }
    if (rms_n.empty()) return all;
    std::sort(rms_n.begin(), rms_n.end());
    all.rms_n = std::sqrt(sum.sum_n2 / double(sum.ticks));
    all.median_path_rms_n = rms_n[rms_n.size() / 2];
    all.worst_path_rms_n = rms_n.back();
    all.largest_n = sum.largest_n;
    all.equal_share = double(sum.equal) / double(sum.ticks);
    return all;
}

}  // namespace stylet::modeller
