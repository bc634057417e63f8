// Helpers shared by the checks.
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
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                const int n2 = x * x + y * y + z * z;
                if (n2 > 0 && double(n2) <= reach_voxels * reach_voxels)
                    ball.push_back({{x, y, z}, std::sqrt(double(n2))});
            }
    const auto order = [](const Offset& o) { return std::tuple(o.length, o.step.z, o.step.y, o.step.x); };
    std::sort(ball.begin(), ball.end(),
              [&](const Offset& a, const Offset& b) { return order(a) < order(b); });
    return ball;
}

constexpr Index3 kFaces[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

}  // namespace stylet::patient::synth
