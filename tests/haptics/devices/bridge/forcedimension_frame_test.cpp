#include "haptics/devices/bridge/forcedimension_frame.h"

#include <gtest/gtest.h>

namespace stylet::haptics::bridge {
namespace {

const Vec3 kRight(1.0, 0.0, 0.0), kUp(0.0, 1.0, 0.0), kToUser(0.0, 0.0, 1.0);

// HZ-FORCE-10
TEST(ForceDimensionFrame, AxesMapToBridgeFrame) {
    EXPECT_EQ(bridgeFromDhd({1.0, 0.0, 0.0}), kToUser);
    EXPECT_EQ(bridgeFromDhd({0.0, 1.0, 0.0}), kRight);
    EXPECT_EQ(bridgeFromDhd({0.0, 0.0, 1.0}), kUp);
    EXPECT_EQ(dhdFromBridge(bridgeFromDhd({1.0, 2.0, 3.0})), Vec3(1.0, 2.0, 3.0));
}

TEST(ForceDimensionFrame, WristRotationRotatesStylus) {
    const double none[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const Pose level = stylusFromDhd({0.01, 0.02, 0.03}, none);
    EXPECT_EQ(level.position_m, Vec3(0.02, 0.03, 0.01));
    EXPECT_NEAR(glm::distance(level.direction({0.0, 0.0, -1.0}), -kToUser), 0.0, 1e-15);
    // A quarter turn about the SDK's z axis, which points up. The SDK's x (toward the user) turns to its y
    // (right).
    const double about_up[3][3] = {{0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
    const Pose turned = stylusFromDhd(Vec3(0.0), about_up);
    EXPECT_NEAR(glm::distance(turned.direction(kToUser), kRight), 0.0, 1e-15);
    EXPECT_NEAR(glm::distance(turned.direction(kUp), kUp), 0.0, 1e-15);
}

}  // namespace
}  // namespace stylet::haptics::bridge
