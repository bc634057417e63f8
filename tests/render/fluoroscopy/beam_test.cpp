#include "render/fluoroscopy/beam.h"

#include <gtest/gtest.h>

#include <numbers>

namespace stylet::render {
namespace {

void expectNear(const Vec3& a, const Vec3& b) {
    EXPECT_LT(glm::length(a - b), 1e-12) << a.x << " " << a.y << " " << a.z;
}

TEST(Beam, SourceIsBelowTheTableAtZeroAngles) {
    const Beam beam = makeBeam({}, Pose{{1, 0, 0, 0}, {0.1, 0.2, 0.3}});
    expectNear(beam.source_m, {0.1, 0.2 - 0.720, 0.3});
    expectNear(beam.detector_m, {0.1, 0.2 + 0.380, 0.3});
    expectNear(beam.right, {-1, 0, 0});
    expectNear(beam.down, {0, 0, -1});
    // Row 0 is toward the head, column 0 toward the patient's right.
    expectNear(pixelAt(beam, 0, 0, 2, 0.3), {0.1 + 0.075, 0.2 + 0.380, 0.3 + 0.075});
}

TEST(Beam, RotatesLikeTheCArmOfTheRoom) {
    const double quarter = std::numbers::pi / 2;
    const Beam left = makeBeam({.orbital_rad = quarter}, {});
    expectNear(left.detector_m, {-0.380, 0, 0});  // the patient's left
    expectNear(left.down, {0, 0, -1});
    const Beam head = makeBeam({.angulation_rad = quarter}, {});
    expectNear(head.detector_m, {0, 0, 0.380});
    expectNear(head.right, {-1, 0, 0});
    // The orbital rotation is applied first, then the angulation.
    const double a = 0.4, o = 0.3;
    const Beam both = makeBeam({.orbital_rad = o, .angulation_rad = a}, {});
    expectNear(both.detector_m,
               0.380 * Vec3(-std::sin(o), std::cos(o) * std::cos(a), std::cos(o) * std::sin(a)));
}

TEST(Collimation, OpenAreaIsExact) {
    EXPECT_DOUBLE_EQ(openArea_m2({}, 0.3), 0.09);
    EXPECT_DOUBLE_EQ(openArea_m2({.left_m = 1, .right_m = 1, .up_m = 1, .down_m = 1}, 0.3), 0.09);
    EXPECT_NEAR(openArea_m2({.left_m = 0.02, .right_m = 0.05, .up_m = 0.03, .down_m = 0.01}, 0.3),
                0.07 * 0.04, 1e-15);
    EXPECT_NEAR(openArea_m2({.left_m = -0.02, .right_m = 0.05, .up_m = 0.03, .down_m = 0.01}, 0.3),
                0.03 * 0.04, 1e-15);
    EXPECT_EQ(openArea_m2({.left_m = -0.06, .right_m = 0.05}, 0.3), 0.0);
    EXPECT_NEAR(openArea_m2({.iris_m = 0.1}, 0.3), std::numbers::pi * 0.01, 1e-5);
    // A quarter of the circle.
    EXPECT_NEAR(openArea_m2({.left_m = 0.0, .up_m = 0.0, .iris_m = 0.1}, 0.3), std::numbers::pi * 0.0025,
                1e-6);
}

TEST(Collimation, EdgesAreOnePixelWide) {
    const Collimation c{.left_m = 0.02, .right_m = 0.05, .up_m = 0.03, .down_m = 0.01};
    EXPECT_EQ(openShare(c, 0.0, 0.0, 0.001), 1.0);
    EXPECT_EQ(openShare(c, -0.021, 0.0, 0.001), 0.0);
    EXPECT_NEAR(openShare(c, -0.020, 0.0, 0.001), 0.5, 1e-12);
    EXPECT_NEAR(openShare(c, 0.0, -0.03025, 0.001), 0.25, 1e-9);
    EXPECT_EQ(openShare({.iris_m = 0.01}, 0.008, 0.008, 0.001), 0.0);
}

}  // namespace
}  // namespace stylet::render
