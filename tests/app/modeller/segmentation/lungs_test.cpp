#include "app/modeller/segmentation/lungs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// A block of tissue, 100 x 60 x 60 voxels of 2 mm.
CtVolume block() {
    return CtVolume({Index3(100, 60, 60), Vec3(0.002), Vec3(0.0)}, 50);
}

void fill(CtVolume& ct, const Index3& low, const Index3& high, std::int16_t hu) {
    forEachVoxel(VoxelBox{low, high}, [&](const Index3& i) { ct[i] = hu; });
}

Lungs segmentLungs(const CtVolume& ct) {
    return findLungs(ct, Mask(ct.grid, 1));
}

TEST(Lungs, TouchingLungsAreSeparated) {
    CtVolume ct = block();
    fill(ct, {10, 10, 20}, {46, 50, 59}, -850);
    fill(ct, {54, 10, 20}, {90, 50, 59}, -850);
    fill(ct, {47, 40, 30}, {53, 42, 50}, -850);  // the anterior junction
    const Lungs l = segmentLungs(ct);
    EXPECT_TRUE(l.notes.empty());
    EXPECT_NEAR(volume_ml(l.left), volume_ml(l.right), 0.02 * volume_ml(l.right));
    EXPECT_TRUE((l.right[{70, 30, 40}]));
    EXPECT_FALSE((l.right[{30, 30, 40}]));
    EXPECT_TRUE((l.left[{30, 30, 40}]));
    EXPECT_NEAR(l.base_right.at(70, 30), 0.039, 1e-6);
    EXPECT_TRUE(std::isnan(l.base_right.at(30, 30)));
}

TEST(Lungs, GasBelowAThinDiaphragmIsExcluded) {
    CtVolume ct = block();
    fill(ct, {54, 10, 30}, {90, 50, 59}, -850);
    fill(ct, {10, 10, 30}, {46, 50, 59}, -850);
    fill(ct, {20, 20, 10}, {40, 40, 29}, -1000);  // a stomach that touches the left lung
    const Lungs l = segmentLungs(ct);
    EXPECT_FALSE((l.left[{30, 30, 20}]));
    EXPECT_TRUE((l.gas[{30, 30, 20}]));
    EXPECT_EQ(countVoxels(l.airways), 0u);
    EXPECT_NEAR(volume_ml(l.left), volume_ml(l.right), 0.03 * volume_ml(l.right));
}

TEST(Lungs, VesselsAreFilledAndTheTracheaIsExcluded) {
    CtVolume ct = block();
    fill(ct, {10, 10, 20}, {44, 50, 59}, -850);
    fill(ct, {56, 10, 20}, {90, 50, 59}, -850);
    fill(ct, {70, 29, 20}, {71, 30, 59}, 60);
    fill(ct, {47, 27, 30}, {53, 33, 59}, -1000);
    const Lungs l = segmentLungs(ct);
    EXPECT_TRUE((l.right[{70, 29, 40}]));
    EXPECT_TRUE((l.airways[{50, 30, 45}]));
    EXPECT_FALSE((l.left[{50, 30, 45}]) || (l.right[{50, 30, 45}]));
}

// The scanner measures too high a value for air. The gas is recognised by its uniformity.
TEST(Lungs, BrightGasIsExcluded) {
    CtVolume ct = block();
    fill(ct, {60, 10, 20}, {90, 50, 59}, -850);
    fill(ct, {10, 10, 10}, {44, 50, 50}, -945);
    const Lungs l = segmentLungs(ct);
    EXPECT_TRUE((l.gas[{27, 30, 30}]));
    EXPECT_EQ(countVoxels(l.left), 0u);
    EXPECT_TRUE((l.right[{75, 30, 40}]));
}

TEST(Lungs, MissingLungsAreReported) {
    CtVolume ct = block();
    EXPECT_EQ(segmentLungs(ct).notes, std::vector<std::string>{"no lung in the section"});
    fill(ct, {60, 10, 20}, {90, 50, 59}, -850);
    const Lungs l = segmentLungs(ct);
    EXPECT_EQ(l.notes, std::vector<std::string>{"only the right lung was found"});
    EXPECT_EQ(countVoxels(l.left), 0u);
}

TEST(Lungs, MatchReferencePatient) {
    const Lungs& l = test::seededLungs();
    EXPECT_GT(test::diceWithTruth({Id::lungRight}, l.right), 0.98);
    EXPECT_GT(test::diceWithTruth({Id::lungLeft}, l.left), 0.98);
    EXPECT_GT(test::diceWithTruth({Id::gas}, l.gas), 0.97);
}

}  // namespace
}  // namespace stylet::modeller
