#include "app/modeller/segmentation/morphology.h"

#include <gtest/gtest.h>

#include "tests/app/modeller/segmentation/made_tubes.h"

namespace stylet::modeller {
namespace {

using test::box;
using test::cube;

TEST(Morphology, AVoxelGrowsToABall) {
    const Mask m = box(cube(21), Index3(10), Index3(10));
    EXPECT_EQ(countOf(dilated(m, 0.001)), 7u);
    EXPECT_EQ(countOf(dilated(m, 0.002)), 33u);
    EXPECT_EQ(countOf(eroded(dilated(m, 0.003), 0.003)), 1u);
}

TEST(Morphology, TheBorderDoesNotErode) {
    const Mask m = box(cube(10), Index3(0), Index3(9, 9, 4));
    EXPECT_EQ(countOf(eroded(m, 0.001)), 400u);
    EXPECT_EQ(closed(m, 0.003).voxels, m.voxels);
}

TEST(Morphology, OpeningCutsABridgeAndClosingMendsAGap) {
    const Grid g = cube(30);
    const Mask blocks = either(box(g, {2, 2, 2}, {12, 12, 12}), box(g, {16, 2, 2}, {26, 12, 12}));
    const Mask joined = either(blocks, box(g, {13, 7, 7}, {15, 7, 7}));
    EXPECT_EQ(piecesOf(joined).count(), 1);
    EXPECT_EQ(piecesOf(opened(joined, 0.002)).count(), 2);
    EXPECT_EQ(piecesOf(closed(blocks, 0.003)).count(), 1);
}

TEST(Morphology, CornersTouchWhereFacesDoNot) {
    const Grid g = cube(5);
    const Mask m = either(box(g, Index3(1), Index3(1)), box(g, Index3(2), Index3(2)));
    EXPECT_EQ(piecesOf(m, Touch::faces).count(), 2);
    EXPECT_EQ(piecesOf(m, Touch::corners).count(), 1);
}

TEST(Morphology, SmallPiecesGoAndCavitiesFill) {
    const Grid g = cube(20);
    Mask m = box(g, Index3(2), Index3(12));
    m[{7, 7, 7}] = 0;
    m[{17, 17, 17}] = 1;
    dropSmall(m, 0.002);
    EXPECT_EQ(countOf(m), 11u * 11u * 11u - 1u);
    fillCavities(m);
    EXPECT_EQ(countOf(m), 11u * 11u * 11u);
    EXPECT_NEAR(volume_ml(m), 1.331, 1e-9);
}

TEST(Morphology, TheNearerSeedTakesAVoxelWithinItsSteps) {
    const Grid g{Index3(11, 1, 1), Vec3(0.001), Vec3(0.0)};
    const Mask all(g, 1);
    LabelVolume seeds(g);
    seeds[{0, 0, 0}] = 1;
    seeds[{8, 0, 0}] = 2;
    const LabelVolume grown = growSeeds(seeds, all);
    EXPECT_EQ(grown.voxels, (std::vector<std::uint8_t>{1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2}));
    EXPECT_EQ(growSeeds(seeds, all, 1).voxels, (std::vector<std::uint8_t>{1, 1, 0, 0, 0, 0, 0, 2, 2, 2, 0}));
}

TEST(Morphology, NothingStaysNothing) {
    const Mask none(cube(4));
    EXPECT_EQ(countOf(closed(none, 0.002)), 0u);
    EXPECT_TRUE(boxOf(none).empty());
    EXPECT_EQ(piecesOf(none).largest(), 0);
}

}  // namespace
}  // namespace stylet::modeller
