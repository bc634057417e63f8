#include "haptics/devices/spacemouse/rate_control.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::haptics {
namespace {

using Axes = std::array<double, 6>;

TEST(RateControl, TheDeadZoneMovesNothing) {
    const RateSettings settings;
    for (const double axis : {0.0, 10.0, -20.0, 27.9, double(NAN)})
        EXPECT_EQ(rateShare(axis, settings), 0.0) << axis;
    EXPECT_GT(rateShare(28.5, settings), 0.0);
    EXPECT_LT(rateShare(28.5, settings), 1e-4) << "no step at its edge";
}

TEST(RateControl, TheShareIsOddMonotoneAndBounded) {
    const RateSettings settings;
    double last = -1.1;
    for (double axis = -700.0; axis <= 700.0; axis += 1.0) {
        const double share = rateShare(axis, settings);
        EXPECT_EQ(share, -rateShare(-axis, settings));
        EXPECT_GE(share, last);
        EXPECT_LE(std::fabs(share), 1.0);
        last = share;
    }
    EXPECT_EQ(rateShare(350.0, settings), 1.0);
    EXPECT_EQ(rateShare(-900.0, settings), -1.0);
    EXPECT_NEAR(rateShare(189.0, settings), 0.25, 1e-12) << "half way out of the dead zone";
}

TEST(RateControl, MovesAtItsSpeedAndTurnsAtItsRate) {
    RateSettings settings;
    settings.speed_m_s = 0.05;
    settings.turn_rad_s = 1.0;
    Pose pose;
    for (int i = 0; i < 1000; ++i)
        stepRate(pose, Axes{0.0, -350.0, 0.0, 0.0, 0.0, 350.0}, settings, 0.001);
    EXPECT_NEAR(pose.position_m.y, -0.05, 1e-12);
    EXPECT_NEAR(pose.rotation.w, std::cos(0.5), 1e-6);
    EXPECT_NEAR(pose.rotation.z, std::sin(0.5), 1e-6);
    EXPECT_NEAR(glm::dot(pose.rotation, pose.rotation), 1.0, 1e-12);
}

TEST(RateControl, StaysWithinReach) {
    RateSettings settings;
    Pose pose;
    for (int i = 0; i < 10000; ++i)
        stepRate(pose, Axes{350.0, 350.0, -350.0, 0.0, 0.0, 0.0}, settings, 0.001);
    EXPECT_NEAR(glm::length(pose.position_m), settings.reach_m, 1e-12);
    EXPECT_NEAR(pose.position_m.x, settings.reach_m / std::sqrt(3.0), 1e-12);
    // The pose can leave the limit again.
    stepRate(pose, Axes{-350.0, -350.0, 350.0, 0.0, 0.0, 0.0}, settings, 0.001);
    EXPECT_LT(glm::length(pose.position_m), settings.reach_m);
}

TEST(RateControl, ClockJumpCausesNoLargeMotion) {
    const RateSettings settings;
    Pose pose;
    const Axes full{350.0, 0.0, 0.0, 350.0, 0.0, 0.0};
    for (const double dt_s : {-1.0, 0.0, double(NAN)}) {
        stepRate(pose, full, settings, dt_s);
        EXPECT_EQ(pose.position_m, Vec3(0.0)) << dt_s;
    }
    stepRate(pose, full, settings, 1e9);
    EXPECT_NEAR(pose.position_m.x, settings.speed_m_s * 0.02, 1e-12);
}

}  // namespace
}  // namespace stylet::haptics
