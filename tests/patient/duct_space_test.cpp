#include "patient/contrast/duct_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/constants.h"
#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

using enum Tissue;

// A duct of 8 mm between x = 10 and 18 mm.
Package layers() {
    return test::makeSlabs({{skin, 0.002}, {liver, 0.008}, {duct, 0.008}, {liver, 0.012}}, 0.001);
}

TEST(DuctSpace, IsTheSignedDistanceToTheWall) {
    const Package package = layers();
    const Patient patient(package);
    const DuctSpace ducts = makeDuctSpace(patient, 2);
    for (double x_m = 0.0065; x_m < 0.0215; x_m += 0.0003) {
        const DuctWall wall = ductWallAt(ducts, {x_m, 0.0004, -0.0007});
        EXPECT_EQ(ductLevelAt(ducts, {x_m, 0.0004, -0.0007}), wall.level_m);
        const double expected_m = std::fabs(x_m - 0.014) - 0.0045;  // half a voxel beyond the duct
        EXPECT_NEAR(wall.level_m, std::clamp(expected_m, -0.004, kFarFromDucts_m), 0.0006) << x_m;
        if (std::fabs(expected_m) > 0.002) continue;
        EXPECT_NEAR(wall.outward.x, x_m > 0.014 ? 1.0 : -1.0, 1e-6) << x_m;
        EXPECT_NEAR(glm::length(wall.outward), 1.0, 1e-9);
        EXPECT_EQ(isInTargetDuct(ducts, {x_m, 0.0004, -0.0007}), wall.level_m < 0.0);
    }
}

TEST(DuctSpace, DoesNotDependOnTheThreads) {
    const Package package = layers();
    const Patient patient(package);
    EXPECT_EQ(makeDuctSpace(patient, 1).level_m.voxels, makeDuctSpace(patient, 4).level_m.voxels);
}

TEST(DuctSpace, IsFarOutsideTheBoxAndForWhatIsNotANumber) {
    const Package package = layers();
    const Patient patient(package);
    const DuctSpace ducts = makeDuctSpace(patient);
    for (const Vec3& p : {Vec3(1.0), Vec3(test::kNaN, 0.0, 0.0), Vec3(0.0, -1e300, 0.0), Vec3(-0.019)}) {
        EXPECT_EQ(ductWallAt(ducts, p).level_m, kFarFromDucts_m);
        EXPECT_EQ(ductLevelAt(ducts, p), kFarFromDucts_m);
        EXPECT_EQ(ductWallAt(ducts, p).outward, Vec3(0.0));
    }
    EXPECT_FALSE(isInTargetDuct(DuctSpace{}, {0.014, 0.0, 0.0}));
}

// A duct of another role (a stricture) is closed to the wire.
TEST(DuctSpace, OnlyTargetDuctsCount) {
    Package package = layers();
    for (Label& label : package.label_table)
        if (label.tissue == duct) label.role = Role::pass;
    const Patient patient(package);
    EXPECT_TRUE(makeDuctSpace(patient).level_m.voxels.empty());
}

}  // namespace
}  // namespace stylet::patient
