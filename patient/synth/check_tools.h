// The steps to all voxels in a ball.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "base/geometry.h"

namespace stylet::patient::synth {

struct Offset {
    Index3 step;
    double length;  // in voxels
};

// All steps up to `reach` voxels long, shortest first.
inline std::vector<Offset> ballOffsets(double reach_voxels) {
    const int reach = int(std::floor(reach_voxels));
    std::vector<Offset> ball;
    forEachVoxel(Index3(-reach), Index3(reach), [&](const Index3& step) {
        const int n2 = step.x * step.x + step.y * step.y + step.z * step.z;
        if (n2 > 0 && double(n2) <= reach_voxels * reach_voxels)
            ball.push_back({step, std::sqrt(double(n2))});
    });
    const auto order = [](const Offset& o) { return std::tuple(o.length, o.step.z, o.step.y, o.step.x); };
    std::sort(ball.begin(), ball.end(),
              [&](const Offset& a, const Offset& b) { return order(a) < order(b); });
    return ball;
}

}  // namespace stylet::patient::synth
