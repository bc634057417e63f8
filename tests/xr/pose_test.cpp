#include "xr/pose.h"

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

TEST(Pose, TheQuaternionIsNormalisedForTheRuntime) {
    const XrPosef given = toXrPose({Quat(4, 0, 3, 0), {1, 2, 3}});
    EXPECT_FLOAT_EQ(given.orientation.y, 0.6f);
    EXPECT_FLOAT_EQ(given.orientation.w, 0.8f);
    EXPECT_EQ(toPose(given).position_m, Vec3(1, 2, 3));
    EXPECT_NEAR(toPose(given).rotation.y, 0.6, 1e-7);
}

}  // namespace
}  // namespace stylet::xr
