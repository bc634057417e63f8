#include "xr/hands.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

TEST(Pinch, StaysClosedBetweenTheTwoDistances) {
    Pinch pinch;
    EXPECT_FALSE(pinch.update(0.030));
    EXPECT_TRUE(pinch.update(0.019));
    EXPECT_TRUE(pinch.update(0.034)) << "a trembling hand does not let go";
    EXPECT_FALSE(pinch.update(0.036));
    EXPECT_FALSE(pinch.update(0.021));
}

TEST(Pinch, OnlyOneFingerPinchesAtATime) {
    Pinches pinches;
    const auto closed = [&](double index_m, double middle_m, double ring_m) {
        pinches.update({index_m, middle_m, ring_m});
        return std::array{pinches.isClosed(PinchFinger::index), pinches.isClosed(PinchFinger::middle),
                          pinches.isClosed(PinchFinger::ring)};
    };
    using ClosedFingers = std::array<bool, kPinchFingers>;
    EXPECT_EQ(closed(0.05, 0.05, 0.05), (ClosedFingers{}));
    EXPECT_EQ(closed(0.018, 0.012, 0.019), (ClosedFingers{false, true, false})) << "the nearest";
    EXPECT_EQ(closed(0.010, 0.030, 0.050), (ClosedFingers{false, true, false}));
    EXPECT_EQ(closed(0.010, 0.040, 0.050), (ClosedFingers{true, false, false}));
    EXPECT_EQ(closed(INFINITY, INFINITY, 0.010), (ClosedFingers{false, false, true}));
    EXPECT_EQ(closed(INFINITY, INFINITY, INFINITY), (ClosedFingers{}));
}

// Palms down, fingers forward: the palm joints are not rotated.
TEST(Hands, AGripPointsFromTheLittleFingerToTheThumb) {
    const Pose palm{Quat(1, 0, 0, 0), {1, 2, 3}};
    for (const int side : {0, 1}) {
        const Pose grip = gripFromPalm(palm, side);
        EXPECT_EQ(grip.position_m, palm.position_m);
        const Vec3 thumbward = grip.direction({0, 0, -1});
        EXPECT_NEAR(thumbward.x, side == 0 ? 1 : -1, 1e-12) << "thumbs point to one another";
        const Vec3 x = grip.direction({1, 0, 0});
        EXPECT_NEAR(x.y, side == 0 ? -1 : 1, 1e-12) << "out of the left palm, into the right one";
        const Vec3 y = grip.direction({0, 1, 0});
        EXPECT_NEAR(y.z, 1, 1e-12);
    }
}

}  // namespace
}  // namespace stylet::xr
