// A phantom of the lung's base.
#pragma once

#include <cmath>
#include <random>

#include "app/modeller/image/voxel_tools.h"
#include "tests/support/seed.h"

namespace stylet::test {

// A lung on a curved diaphragm, blurred across slices by a normal distribution.
inline CtVolume lungOnDiaphragm(double blur_voxels, double noise_hu, double slope = 0.05,
                                double lung_hu = -850.0) {
    CtVolume ct({Index3(60, 60, 60), Vec3(0.001), Vec3(0.0)}, -1000);
    std::mt19937_64 random(test::seed());
    std::normal_distribution<double> noise(0.0, noise_hu);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const double base = 30.3 - 0.002 * (i.x - 30) * (i.x - 30) + slope * (i.y - 30);
        const double share = 0.5 * std::erfc((i.z - base) / (blur_voxels * std::sqrt(2.0)));
        ct[i] = std::int16_t(std::lround(lung_hu + (80.0 - lung_hu) * share + noise(random)));
    });
    return ct;
}

}  // namespace stylet::test
