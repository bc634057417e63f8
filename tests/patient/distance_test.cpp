#include "base/distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace stylet::patient {
namespace {

Grid smallGrid() {
    Grid grid;
    grid.dims = {13, 9, 11};
    grid.spacing_m = {0.001, 0.0025, 0.0017};
    grid.origin_m = {0.1, -0.2, 0.3};
    return grid;
}

double bruteForce(const Volume<std::uint8_t>& mask, const Index3& from, Sites sites) {
    double nearest = std::numeric_limits<double>::infinity();
    forEachVoxel(mask.grid, [&](const Index3& i) {
        if (!mask[i] || (sites == Sites::above && i.z < from.z)) return;
        nearest = std::min(nearest, glm::length(mask.grid.centre(i) - mask.grid.centre(from)));
    });
    return nearest;
}

TEST(Distance, EqualsBruteForce) {
    std::mt19937 random(6);
    for (const double share : {0.003, 0.05, 0.6})
        for (const Sites sites : {Sites::all, Sites::above}) {
            Volume<std::uint8_t> mask(smallGrid());
            for (std::uint8_t& m : mask.voxels)
                m = std::bernoulli_distribution(share)(random);
            const Volume<float> distance = distanceTo(mask, sites, 2);
            forEachVoxel(mask.grid, [&](const Index3& i) {
                const double expected = bruteForce(mask, i, sites), got = double(distance[i]);
                if (std::isinf(expected))
                    EXPECT_TRUE(std::isinf(got));
                else
                    EXPECT_NEAR(got, expected, 1e-8);
            });
        }
}

TEST(Distance, IsInfiniteWithoutSitesAndIndependentOfThreads) {
    Volume<std::uint8_t> mask(smallGrid());
    for (const float d : distanceTo(mask, Sites::all, 1).voxels)
        EXPECT_TRUE(std::isinf(d));
    mask[Index3(3, 4, 5)] = mask[Index3(12, 0, 10)] = 1;
    EXPECT_EQ(distanceTo(mask, Sites::all, 1).voxels, distanceTo(mask, Sites::all, 3).voxels);
}

TEST(LinearAt, IsExactForLinearFieldsAndConstantBeyond) {
    Volume<float> field(smallGrid());
    forEachVoxel(field.grid, [&](const Index3& i) { field[i] = float(i.x + 10 * i.y + 100 * i.z); });
    EXPECT_NEAR(sampleTrilinear(field, field.grid.centre({4, 5, 6})), 654.0, 1e-9);
    EXPECT_NEAR(sampleTrilinear(field, field.grid.origin_m + field.grid.spacing_m * Vec3(4.25, 5.5, 6.75)),
                734.25, 1e-6);
    EXPECT_NEAR(sampleTrilinear(field, Vec3(9.0, 9.0, 9.0)), 12 + 80 + 1000, 1e-9);
    EXPECT_NEAR(sampleTrilinear(field, Vec3(-9.0, -9.0, -9.0)), 0.0, 1e-9);
}

}  // namespace
}  // namespace stylet::patient
