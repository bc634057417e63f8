#include "xr/pose.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

const double kHalf = std::sqrt(0.5);
const Pose kTurnedLeft{{0, kHalf, 0, kHalf}, {1, 2, 3}};  // a quarter turn about +y turns -z to -x

TEST(Pose, RotatesByTheRightHandRule) {
    const auto v = rotate(kTurnedLeft, {0, 0, -1});
    EXPECT_NEAR(v[0], -1, 1e-12);
    EXPECT_NEAR(v[2], 0, 1e-12);
    const auto x = rotate({{kHalf, 0, 0, kHalf}, {}}, {0, 1, 0});
    EXPECT_NEAR(x[2], 1, 1e-12);
}

TEST(Pose, ComposesLeftToRight) {
    const Pose a = kTurnedLeft * Pose{{0, 0, 0, 1}, {0, 0, -2}};
    EXPECT_NEAR(a.position[0], -1, 1e-12);
    EXPECT_NEAR(a.position[1], 2, 1e-12);
    EXPECT_NEAR(a.position[2], 3, 1e-12);
    const Pose twice = kTurnedLeft * kTurnedLeft;
    EXPECT_NEAR(std::abs(twice.orientation[1]), 1, 1e-12);
}

TEST(Pose, TheInverseCancels) {
    const Pose tilted = kTurnedLeft * Pose{{kHalf, 0, 0, kHalf}, {0.3, -0.2, 0.1}};
    for (const Pose& none : {tilted * inverse(tilted), inverse(tilted) * tilted}) {
        EXPECT_NEAR(std::abs(none.orientation[3]), 1, 1e-12);
        for (const double p : none.position)
            EXPECT_NEAR(p, 0, 1e-12);
    }
}

TEST(Pose, TheQuaternionIsNormalisedForTheRuntime) {
    const XrPosef given = toXrPose({{0, 3, 0, 4}, {1, 2, 3}});
    EXPECT_FLOAT_EQ(given.orientation.y, 0.6f);
    EXPECT_FLOAT_EQ(given.orientation.w, 0.8f);
    EXPECT_EQ(toPose(given).position, (std::array<double, 3>{1, 2, 3}));
}

}  // namespace
}  // namespace stylet::xr
