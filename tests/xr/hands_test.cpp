#include "xr/hands.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stylet::xr {
namespace {

TEST(Pinch, HoldsBetweenTheTwoDistances) {
    Pinch pinch;
    EXPECT_FALSE(pinch.update(0.030));
    EXPECT_TRUE(pinch.update(0.019));
    EXPECT_TRUE(pinch.update(0.034)) << "a trembling hand does not let go";
    EXPECT_FALSE(pinch.update(0.036));
    EXPECT_FALSE(pinch.update(0.021));
}

// Palms down, fingers forward: the palm joints are unturned.
TEST(Hands, AGripPointsFromTheLittleFingerToTheThumb) {
    const Pose palm{{0, 0, 0, 1}, {1, 2, 3}};
    for (const int side : {0, 1}) {
        const Pose grip = gripOfPalm(palm, side);
        EXPECT_EQ(grip.position, palm.position);
        const auto thumbward = rotate(grip, {0, 0, -1});
        EXPECT_NEAR(thumbward[0], side == 0 ? 1 : -1, 1e-12) << "thumbs point to one another";
        const auto x = rotate(grip, {1, 0, 0});
        EXPECT_NEAR(x[1], side == 0 ? -1 : 1, 1e-12) << "out of the left palm, into the right one";
        const auto y = rotate(grip, {0, 1, 0});
        EXPECT_NEAR(y[2], 1, 1e-12);
    }
}

}  // namespace
}  // namespace stylet::xr
