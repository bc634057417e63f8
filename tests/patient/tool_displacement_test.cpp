#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

constexpr double kFrame_s = 1.0 / 90.0;

// Soft tissue everywhere, in a volume larger than any simulation box. Only the tool and the box shape the
// displacement.
Package makeBlock(Tissue tissue) {
    Package package = test::makeSlabs({{Tissue::soft, 0.04}}, 0.004);
    Grid grid;
    grid.dims = Index3(49);
    grid.spacing_m = Vec3(0.004);
    grid.origin_m = Vec3(-24 * 0.004);
    package.ct = CtVolume(grid, std::int16_t(40));
    package.labels = LabelVolume(grid, std::uint8_t(tissue));
    return package;
}

// Air for x < 0, then skin and fat. Bone starts at 12 mm.
Package makeCoveredBone() {
    return test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.010}, {Tissue::bone, 0.008}}, 0.001);
}

ToolContact ball(const Vec3& at_m, const Vec3& moved_m, double radius_m = 0.004) {
    return {.id = 0,
            .begin_m = at_m,
            .end_m = at_m,
            .begin_moved_m = moved_m,
            .end_moved_m = moved_m,
            .radius_m = radius_m};
}

// Holds the contact until the displacement no longer changes.
void updateUntilSteady(ToolDisplacement& tool, const ToolContact& contact, const Surrogate& breath = {},
                       int frames = 12) {
    for (int i = 0; i < frames; ++i)
        tool.update({&contact, 1}, breath, kFrame_s);
}

TEST(ToolDisplacement, IsInactiveWithoutContact) {
    const test::OwnedPatient patient(makeCoveredBone());
    ToolDisplacement tool(patient);
    EXPECT_FALSE(tool.update({}, {}, kFrame_s));
    EXPECT_FALSE(tool.active());
    const ToolContact idle = ball(Vec3(0.0), Vec3(0.0));
    EXPECT_FALSE(tool.update({&idle, 1}, {}, kFrame_s));
}

TEST(ToolDisplacement, SkinFollowsThePressingTool) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    for (const double depth_m : {0.001, 0.003, 0.008}) {
        ToolDisplacement tool(patient);
        const Vec3 moved(0.0, 0.0, -depth_m);
        updateUntilSteady(tool, ball(Vec3(0.0), moved));
        const Vec3 there = displacementAt(tool.table(), moved);
        EXPECT_LT(glm::length(there - moved), 0.05 * depth_m) << depth_m;
    }
}

// Outside the contact patch and away from the box's corners u = A/r + B, the decay in a uniform medium.
TEST(ToolDisplacement, FallsAsOneOverTheDistanceInAUniformMedium) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    ToolDisplacement tool(patient, {.cycles = 4});
    updateUntilSteady(tool, ball(Vec3(0.0), Vec3(0.0, 0.0, 0.0005), 0.009));
    const auto u = [&](double x) { return glm::length(displacementAt(tool.table(), Vec3(x, 0.0, 0.0))); };
    // A ratio of differences at three distances eliminates A and B: (1/a - 1/b) / (1/b - 1/c).
    const double expected = (1.0 / 0.012 - 1.0 / 0.018) / (1.0 / 0.018 - 1.0 / 0.024);
    EXPECT_NEAR((u(0.012) - u(0.018)) / (u(0.018) - u(0.024)), expected, 0.06 * expected);
}

TEST(ToolDisplacement, AgreesWithFinerNodes) {
    const test::OwnedPatient patient(makeCoveredBone());
    ToolDisplacement usual(patient), fine(patient, {.nodes = 65, .spacing_m = 0.0015, .cycles = 8});
    const ToolContact contact = ball(Vec3(0.0), Vec3(0.004, 0.0, 0.001));
    updateUntilSteady(usual, contact), updateUntilSteady(fine, contact);
    double most_m = 0.0;
    for (double x = -0.006; x < 0.012; x += 0.0011)
        for (double y = -0.017; y <= 0.017; y += 0.0013)
            for (double z = -0.017; z <= 0.017; z += 0.0017) {
                const Vec3 p(x, y, z);
                most_m = std::max(
                    most_m, glm::length(displacementAt(usual.table(), p) - displacementAt(fine.table(), p)));
            }
    EXPECT_LT(most_m, 8e-4);
}

TEST(ToolDisplacement, BoneDoesNotMove) {
    const test::OwnedPatient patient(makeCoveredBone());
    ToolDisplacement tool(patient);
    updateUntilSteady(tool, ball(Vec3(0.0), Vec3(0.006, 0.0, 0.0), 0.006));
    for (double y = -0.018; y <= 0.018; y += 0.003)
        for (const double x : {0.0155, 0.018})
            EXPECT_LT(glm::length(displacementAt(tool.table(), {x, y, 0.002})), 1e-4) << x << ' ' << y;
    EXPECT_GT(displacementAt(tool.table(), {0.006, 0.0, 0.0}).x, 0.005);
}

// Breathing moves the bone away from under the tool.
TEST(ToolDisplacement, FindsBoneThroughTheBreath) {
    Package package = makeCoveredBone();
    package.motion = test::makeShift(0.030);
    const Patient patient(package);
    const ToolContact contact = ball(Vec3(0.0), Vec3(0.004, 0.0, 0.0));
    ToolDisplacement still(patient), carried(patient);
    updateUntilSteady(still, contact), updateUntilSteady(carried, contact, {1.0, 0.0});
    // The slab now ends at z = -20 mm + 30 mm of travel, so this point is in air.
    const Vec3 bone(0.016, 0.0, 0.0);
    EXPECT_LT(glm::length(displacementAt(still.table(), bone)), 1e-4);
    EXPECT_GT(glm::length(displacementAt(carried.table(), bone)), 5e-4);
}

// Smallest determinant of the Jacobian of p -> p - u, at the corners of every cell of the trilinear map.
double minJacobian(const DisplacementTable& table) {
    const Grid& g = table.grid;
    const auto at = [&](const Index3& i) { return g.centre(i) - Vec3(table.moved_m[g.offset(i)]); };
    double least = 1.0;
    forEachVoxel(Index3(0), g.dims - 2, [&](const Index3& i) {
        for (int k = 0; k < 8; ++k) {
            const Index3 c(k & 1, k >> 1 & 1, k >> 2);
            const auto edge = [&](int axis) {
                Index3 low = c, high = c;
                low[axis] = 0, high[axis] = 1;
                return (at(i + high) - at(i + low)) / g.spacing_m[axis];
            };
            least = std::min(least, glm::determinant(Mat3(edge(0), edge(1), edge(2))));
        }
    });
    return least;
}

TEST(ToolDisplacement, NeverFolds) {
    const Package covered = makeCoveredBone(), soft = makeBlock(Tissue::soft);
    for (const Package* package : {&covered, &soft}) {
        const Patient patient(*package);
        for (const double depth_m : {0.002, 0.006, 0.010, 0.015})
            for (const double sign : {1.0, -1.0}) {
                ToolDisplacement tool(patient);
                updateUntilSteady(tool, ball(Vec3(0.0), Vec3(sign * depth_m, 0.2 * depth_m, 0.0)), {}, 3);
                EXPECT_GT(minJacobian(tool.table()), 0.0) << sign * depth_m;
            }
    }
}

TEST(ToolDisplacement, IsSymmetricAboutTheTool) {
    const test::OwnedPatient patient(makeBlock(Tissue::liver));
    ToolDisplacement tool(patient);
    updateUntilSteady(tool, ball(Vec3(0.0), Vec3(0.0, 0.0, 0.005)));
    for (const Vec3 p : {Vec3(0.007, 0.003, 0.002), Vec3(0.015, 0.001, -0.010)}) {
        const Vec3 u = displacementAt(tool.table(), p);
        const Vec3 mirrored = displacementAt(tool.table(), {-p.x, p.y, p.z});
        EXPECT_LT(glm::length(u - Vec3(mirrored)), 1e-5);
        EXPECT_LT(glm::length(u - displacementAt(tool.table(), {p.y, p.x, p.z})), 1e-5);
    }
    // Pulling is the mirror image of pushing.
    ToolDisplacement pull(patient);
    updateUntilSteady(pull, ball(Vec3(0.0), Vec3(0.0, 0.0, -0.005)));
    const Vec3 u = displacementAt(tool.table(), {0.006, 0.0, 0.002});
    EXPECT_LT(glm::length(u + displacementAt(pull.table(), {0.006, 0.0, -0.002})), 1e-5);
}

TEST(ToolDisplacement, IsZeroAtTheBoxAndBeyond) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    ToolDisplacement tool(patient);
    updateUntilSteady(tool, ball(Vec3(0.01, 0.0, 0.0), Vec3(0.0, 0.010, 0.0)));
    const Grid& g = tool.table().grid;
    forEachVoxel(g, [&](const Index3& i) {
        if (!g.atBorder(i)) return;
        ASSERT_EQ(tool.table().moved_m[g.offset(i)], glm::vec4(0.0f));
    });
    EXPECT_EQ(displacementAt(tool.table(), g.origin_m - 0.001), Vec3(0.0));
    EXPECT_EQ(displacementAt(tool.table(), {1.0, 0.0, 0.0}), Vec3(0.0));
}

TEST(ToolDisplacement, FollowsPressureAtOnceAndRecoilsExponentially) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    const ToolDisplacementSettings settings{.cycles = 6};
    ToolDisplacement tool(patient, settings);
    const Vec3 moved(0.0, 0.0, -0.004);
    updateUntilSteady(tool, ball(Vec3(0.0), moved));
    const auto depth = [&] { return -displacementAt(tool.table(), Vec3(0.0)).z; };
    const double pressed_m = depth();
    const ToolContact deeper = ball(Vec3(0.0), 1.5 * moved);
    tool.update({&deeper, 1}, {}, kFrame_s);
    EXPECT_GT(depth(), 1.3 * pressed_m);
    tool.update({&deeper, 1}, {}, 1.0);
    // Release.
    const double before_m = depth();
    double t_s = 0.0;
    while (t_s < settings.recoil_s - 1e-9)
        tool.update({}, {}, 0.010), t_s += 0.010;
    EXPECT_NEAR(depth() / before_m, std::exp(-1.0), 0.04);
    for (int i = 0; i < 60; ++i)
        tool.update({}, {}, 0.010);
    EXPECT_FALSE(tool.active());
}

// A tool lifted more slowly than the skin recoils stays in contact with the skin.
TEST(ToolDisplacement, SkinStaysInContactWithASlowlyLiftedTool) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    ToolDisplacement tool(patient, {.cycles = 6});
    updateUntilSteady(tool, ball(Vec3(0.0), Vec3(0.0, 0.0, -0.006)));
    for (double depth_m = 0.006; depth_m > 0.003; depth_m -= 0.0005) {
        const ToolContact contact = ball(Vec3(0.0), Vec3(0.0, 0.0, -depth_m));
        tool.update({&contact, 1}, {}, kFrame_s);
        EXPECT_NEAR(-displacementAt(tool.table(), contact.begin_moved_m).z, depth_m, 0.06 * depth_m);
    }
}

// A needle that is withdrawn pulls the skin up: a capsule along the shaft drags it along.
TEST(ToolDisplacement, ShaftDragsTheSkin) {
    const test::OwnedPatient patient(makeCoveredBone());
    ToolDisplacement tool(patient);
    const ToolContact shaft{.id = 0,
                            .begin_m = Vec3(0.0),
                            .end_m = Vec3(0.010, 0.0, 0.0),
                            .begin_moved_m = Vec3(-0.0005, 0.0, 0.0),
                            .end_moved_m = Vec3(-0.001, 0.0, 0.0)};
    updateUntilSteady(tool, shaft);
    EXPECT_NEAR(displacementAt(tool.table(), Vec3(0.0)).x, -0.0005, 1e-4);
    EXPECT_NEAR(displacementAt(tool.table(), Vec3(0.005, 0.0, 0.0)).x, -0.00075, 1e-4);
    EXPECT_LT(displacementAt(tool.table(), Vec3(0.001, 0.004, 0.0)).x, -0.0001);
}

// A long shaft gets a larger box. A box moves only when necessary.
TEST(ToolDisplacement, BoxContainsAllContacts) {
    const test::OwnedPatient patient(makeBlock(Tissue::soft));
    ToolDisplacement tool(patient);
    ToolContact shaft = ball(Vec3(-0.045, 0.0, 0.0), Vec3(0.001, 0.0, 0.0));
    shaft.end_m.x = 0.045;
    updateUntilSteady(tool, shaft, {}, 3);
    const Grid wide = tool.table().grid;
    EXPECT_GT(displacementAt(tool.table(), Vec3(0.044, 0.0, 0.0)).x, 0.0008);
    EXPECT_GT(displacementAt(tool.table(), Vec3(-0.044, 0.0, 0.0)).x, 0.0008);
    shaft.end_m.x = 0.047;
    updateUntilSteady(tool, shaft, {}, 1);
    EXPECT_EQ(tool.table().grid, wide);
}

}  // namespace
}  // namespace stylet::patient
