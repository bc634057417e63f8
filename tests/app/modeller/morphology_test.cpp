#include "app/modeller/image/morphology.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/app/modeller/segmentation/liver_phantom.h"

namespace stylet::modeller {
namespace {

using test::box;
using test::cube;

TEST(Morphology, VoxelDilatesToABall) {
    const Mask m = box(cube(21), Index3(10), Index3(10));
    EXPECT_EQ(countVoxels(dilated(m, 0.001)), 7u);
    EXPECT_EQ(countVoxels(dilated(m, 0.002)), 33u);
    EXPECT_EQ(countVoxels(eroded(dilated(m, 0.003), 0.003)), 1u);
}

// Gives the same voxels as the distance transform, also for anisotropic voxels, for radii of whole voxels,
// and for radii larger than the grid.
TEST(Morphology, DilationIsExact) {
    const Grid g{Index3(23, 17, 19), Vec3(0.0007, 0.0010, 0.0025), Vec3(0.0)};
    std::mt19937 random(5);
    for (const double share : {0.0005, 0.01, 0.5}) {
        const Mask m = maskWhere(g, [&](std::size_t) { return random() < share * 4294967296.0; });
        const FloatVolume to_mask = distanceTo(m), to_rest = distanceTo(inverted(m));
        for (const double radius_m : {0.0, 0.0005, 0.0014, 0.0020, 0.0025, 0.0031, 0.0072, 0.060}) {
            const float reach_m = float(1.0001 * radius_m);
            EXPECT_EQ(dilated(m, radius_m).voxels,
                      maskWhere(g, [&](std::size_t i) { return to_mask.voxels[i] <= reach_m; }).voxels)
                << share << " " << radius_m;
            EXPECT_EQ(eroded(m, radius_m).voxels,
                      maskWhere(g, [&](std::size_t i) { return m.voxels[i] && to_rest.voxels[i] > reach_m; })
                          .voxels)
                << share << " " << radius_m;
        }
    }
}

TEST(Morphology, GridBorderDoesNotErode) {
    const Mask m = box(cube(10), Index3(0), Index3(9, 9, 4));
    EXPECT_EQ(countVoxels(eroded(m, 0.001)), 400u);
    EXPECT_EQ(closed(m, 0.003).voxels, m.voxels);
}

TEST(Morphology, OpeningRemovesABridgeAndClosingFillsAGap) {
    const Grid g = cube(30);
    const Mask blocks = unite(box(g, {2, 2, 2}, {12, 12, 12}), box(g, {16, 2, 2}, {26, 12, 12}));
    const Mask joined = unite(blocks, box(g, {13, 7, 7}, {15, 7, 7}));
    EXPECT_EQ(findComponents(joined).count(), 1);
    EXPECT_EQ(findComponents(opened(joined, 0.002)).count(), 2);
    EXPECT_EQ(findComponents(closed(blocks, 0.003)).count(), 1);
}

TEST(Morphology, CornerConnectivityJoinsDiagonalVoxels) {
    const Grid g = cube(5);
    const Mask m = unite(box(g, Index3(1), Index3(1)), box(g, Index3(2), Index3(2)));
    EXPECT_EQ(findComponents(m, Connectivity::faces).count(), 2);
    EXPECT_EQ(findComponents(m, Connectivity::corners).count(), 1);
}

TEST(Morphology, SmallComponentsAreRemovedAndCavitiesFilled) {
    const Grid g = cube(20);
    Mask m = box(g, Index3(2), Index3(12));
    m[{7, 7, 7}] = 0;
    m[{17, 17, 17}] = 1;
    removeSmallComponents(m, 0.002);
    EXPECT_EQ(countVoxels(m), 11u * 11u * 11u - 1u);
    fillCavities(m);
    EXPECT_EQ(countVoxels(m), 11u * 11u * 11u);
    EXPECT_NEAR(volume_ml(m), 1.331, 1e-9);
}

TEST(Morphology, VoxelGetsTheNearestSeedWithinTheSteps) {
    const Grid g{Index3(11, 1, 1), Vec3(0.001), Vec3(0.0)};
    const Mask all(g, 1);
    LabelVolume seeds(g);
    seeds[{0, 0, 0}] = 1;
    seeds[{8, 0, 0}] = 2;
    const LabelVolume grown = growSeeds(seeds, all);
    EXPECT_EQ(grown.voxels, (std::vector<std::uint8_t>{1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2}));
    EXPECT_EQ(growSeeds(seeds, all, 1).voxels, (std::vector<std::uint8_t>{1, 1, 0, 0, 0, 0, 0, 2, 2, 2, 0}));
}

TEST(Morphology, EmptyMaskStaysEmpty) {
    const Mask none(cube(4));
    EXPECT_EQ(countVoxels(closed(none, 0.002)), 0u);
    EXPECT_TRUE(boundingBox(none).empty());
    EXPECT_EQ(findComponents(none).largest(), 0);
}

}  // namespace
}  // namespace stylet::modeller
