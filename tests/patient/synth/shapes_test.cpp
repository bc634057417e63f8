#include "patient/synth/shapes.h"

#include <gtest/gtest.h>

namespace stylet::patient::synth {
namespace {

TEST(Shapes, EllipsoidOfEqualRadiiIsASphere) {
    EXPECT_NEAR(ellipsoid({3, 4, 0}, Vec3(0.0), Vec3(2.0)), 3.0, 1e-12);
    EXPECT_NEAR(ellipsoid({0.6, 0.8, 0}, Vec3(0.0), Vec3(2.0)), -1.0, 1e-12);
    EXPECT_NEAR(ellipsoid({1, 7, 1}, Vec3(1.0), {2, 3, 4}), 3.0, 1e-12);
}

TEST(Shapes, RoundConeTapersLinearly) {
    const ConeHit middle = roundCone({5, 3, 0}, Vec3(0.0), {10, 0, 0}, 2.0, 1.0);
    EXPECT_DOUBLE_EQ(middle.share, 0.5);
    EXPECT_DOUBLE_EQ(middle.distance, 1.5);
    EXPECT_DOUBLE_EQ(roundCone({-4, 0, 0}, Vec3(0.0), {10, 0, 0}, 2.0, 1.0).distance, 2.0);
    EXPECT_DOUBLE_EQ(roundCone({1, 0, 0}, Vec3(0.0), Vec3(0.0), 3.0, 3.0).distance, -2.0);
}

TEST(Shapes, SmoothMaximumTouchesTheMaximumAwayFromTheEdge) {
    EXPECT_DOUBLE_EQ(smoothMax(1.0, 9.0, 4.0), 9.0);
    EXPECT_DOUBLE_EQ(smoothMax(2.0, 2.0, 4.0), 3.0);
    EXPECT_DOUBLE_EQ(smoothMin(2.0, 2.0, 4.0), 1.0);
}

TEST(Shapes, CurvePassesThroughItsKnotsAndIsFlatBeyond) {
    constexpr Knot knots[] = {{0, 1}, {2, 5}, {3, 4}};
    for (const Knot& k : knots)
        EXPECT_NEAR(curve(knots, k.x), k.y, 1e-12);
    EXPECT_DOUBLE_EQ(curve(knots, -7), 1.0);
    EXPECT_DOUBLE_EQ(curve(knots, 8), 4.0);
    // C1 continuity at the inner knot.
    const double h = 1e-6;
    EXPECT_NEAR((curve(knots, 2 + h) - curve(knots, 2)) / h, (curve(knots, 2) - curve(knots, 2 - h)) / h,
                1e-4);
}

}  // namespace
}  // namespace stylet::patient::synth
