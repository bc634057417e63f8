// Distances and overlaps of boxes with known results.
#include "app/modeller/segmentation/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/modeller/segmentation/judgement.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"

namespace stylet::modeller {
namespace {

using test::box;

const Grid kBoxGrid{Index3(40), Vec3(0.002), Vec3(0.0)};

TEST(Accuracy, IdenticalMasksAgreePerfectly) {
    const Mask a = box(kBoxGrid, Index3(10), Index3(19));
    const Agreement same = compare(a, a);
    EXPECT_EQ(same.dice, 1.0);
    EXPECT_EQ(same.mean_surface_m, 0.0);
    EXPECT_EQ(same.hausdorff_m, 0.0);
    EXPECT_NEAR(same.truth_ml, 8.0, 1e-9);
}

TEST(Accuracy, ShiftedBoxHasKnownDiceAndHausdorff) {
    const Agreement shifted =
        compare(box(kBoxGrid, Index3(10), Index3(19)), box(kBoxGrid, {12, 10, 10}, {21, 19, 19}));
    EXPECT_NEAR(shifted.dice, 0.8, 1e-12);
    EXPECT_NEAR(shifted.hausdorff_m, 0.004, 1e-8);
    EXPECT_GT(shifted.mean_surface_m, 0.0);
    EXPECT_LT(shifted.mean_surface_m, 0.004);
}

// Every surface voxel of the inner box is 3 voxels from the outer box's surface. The corners of the outer
// box are 3 sqrt(3) voxels from the inner box.
TEST(Accuracy, NestedBoxesHaveKnownDiceAndHausdorff) {
    const Agreement nested =
        compare(box(kBoxGrid, Index3(8), Index3(27)), box(kBoxGrid, Index3(11), Index3(24)));
    EXPECT_NEAR(nested.dice, 2.0 * 14 * 14 * 14 / (20.0 * 20 * 20 + 14.0 * 14 * 14), 1e-12);
    EXPECT_NEAR(nested.hausdorff_m, 0.006 * std::sqrt(3.0), 1e-7);
    EXPECT_GE(nested.mean_surface_m, 0.006 - 1e-8);
}

// The region of the first comparison contains the moved face only. Each of its voxels is two voxels from the
// other box's face.
TEST(Accuracy, RegionHasItsOwnMeanSurfaceDistance) {
    const Mask a = box(kBoxGrid, Index3(10), Index3(19)), b = box(kBoxGrid, Index3(10), {21, 19, 19});
    EXPECT_NEAR(compare(a, b, box(kBoxGrid, {19, 13, 13}, {21, 16, 16})).mean_surface_near_m, 0.004, 1e-8);
    EXPECT_EQ(compare(a, b, box(kBoxGrid, {10, 13, 13}, {11, 16, 16})).mean_surface_near_m, 0.0);
    EXPECT_TRUE(std::isnan(compare(a, b, box(kBoxGrid, Index3(30), Index3(32))).mean_surface_near_m));
}

// A vein, behind it an artery, and a gallbladder that is no risk here.
TEST(Accuracy, PathsThatCrossATrueRiskAreCounted) {
    patient::Package truth;
    truth.labels = LabelVolume(kBoxGrid);
    const auto paint = [&](std::uint8_t id, const char* name, patient::Role role, int from_x, int to_x) {
        patient::Label label;
        label.id = id, label.name = name, label.role = role;
        truth.label_table.push_back(label);
        forEachVoxel(VoxelBox{{from_x, 10, 10}, {to_x, 19, 19}},
                     [&](const Index3& i) { truth.labels[i] = id; });
    };
    paint(7, "vein", patient::Role::risk, 20, 21);
    paint(8, "artery", patient::Role::risk, 25, 30);
    paint(9, "gallbladder", patient::Role::pass, 32, 35);
    const auto path = [](const Vec3& from, const Vec3& to) {
        patient::PlannedPath p;
        p.entry_reference_m = kBoxGrid.spacing_m * from, p.target_reference_m = kBoxGrid.spacing_m * to;
        return p;
    };
    const std::vector<patient::PlannedPath> paths{
        path({10, 15, 15}, {39, 15, 15}),                        // crosses both: counted for the vein
        path({39, 15, 15}, {23, 15, 15}),                        // comes from the other side: the artery
        path({10, 15, 15}, {19.4, 15, 15}),                      // ends before the vein
        path({10, 15, 15}, {19.6, 15, 15}),                      // ends in it
        path({10, 9.4, 15}, {39, 9.4, 15}),                      // passes beside all
        path({31, 15, 15}, {39, 15, 15}),                        // through the gallbladder only
        path({-50, 90, 15}, {-10, 90, 15}),                      // outside the volume
        path({19.5 - 5, 9.5 + 5, 15}, {19.5 + 5, 9.5 - 5, 15}),  // touches an edge of the vein
    };
    EXPECT_EQ(countRiskCrossings(truth, paths),
              (std::map<std::string, std::size_t>{{"artery", 1}, {"vein", 2}}));
}

TEST(Accuracy, EmptyMaskHasInfiniteDistance) {
    const Agreement none = compare(box(kBoxGrid, Index3(10), Index3(19)), Mask(kBoxGrid));
    EXPECT_EQ(none.dice, 0.0);
    EXPECT_TRUE(std::isinf(none.mean_surface_m));
    EXPECT_EQ(compare(Mask(kBoxGrid), Mask(kBoxGrid)).dice, 1.0);
}

}  // namespace
}  // namespace stylet::modeller
