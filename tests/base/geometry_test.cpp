#include "base/geometry.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace stylet {
namespace {

const double kHalf = std::sqrt(0.5);
const Pose kTurnedLeft{Quat(kHalf, 0, kHalf, 0), {1, 2, 3}};  // a quarter turn about +y turns -z to -x
const Pose kTurnedBack{Quat(kHalf, kHalf, 0, 0), {0.3, -0.2, 0.1}};

void expectNear(const Vec3& actual, const Vec3& expected) {
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(actual[axis], expected[axis], 1e-12) << "axis " << axis;
}

TEST(Pose, RotatesByTheRightHandRule) {
    expectNear(kTurnedLeft.direction({0, 0, -1}), {-1, 0, 0});
    expectNear(kTurnedBack.direction({0, 1, 0}), {0, 0, 1});
}

TEST(Pose, ComposesLeftToRight) {
    const Vec3 point(0.4, 0.5, -0.6);
    expectNear((kTurnedLeft * kTurnedBack) * point, kTurnedLeft * (kTurnedBack * point));
    expectNear(kTurnedLeft * Vec3(0, 0, -2), {-1, 2, 3});
}

TEST(Pose, TheInverseCancels) {
    const Pose tilted = kTurnedLeft * kTurnedBack;
    for (const Pose& none : {tilted * tilted.inverse(), tilted.inverse() * tilted}) {
        expectNear(none.position_m, Vec3(0.0));
        EXPECT_NEAR(std::abs(none.rotation.w), 1, 1e-12);
    }
}

TEST(Pose, ANumberThatIsNotFiniteIsFound) {
    EXPECT_TRUE(isFinite(kTurnedLeft));
    for (int part = 0; part < 7; ++part) {
        Pose broken = kTurnedLeft;
        (part < 3 ? broken.position_m[part] : broken.rotation[part - 3]) =
            part % 2 ? std::numeric_limits<double>::infinity() : std::nan("");
        EXPECT_FALSE(isFinite(broken)) << "part " << part;
    }
}

}  // namespace
}  // namespace stylet
