#include "haptics/tools/tenting.h"

#include <gtest/gtest.h>

namespace stylet::haptics {
namespace {

constexpr patient::TissueRow kFascia{2.5, 1.0, 1000.0, true, patient::Role::pass};

TEST(Tenting, EveryShareReachesTheThresholdAtTheSameDepth) {
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const TentingCurve c = tentingCurve(kFascia, 0.7, share);
        EXPECT_DOUBLE_EQ(c.cut_depth_m, 0.0018);
        EXPECT_DOUBLE_EQ(c.force_n(0.0), 0.7);
        EXPECT_NEAR(c.force_n(c.cut_depth_m), 2.5, 1e-14);
        EXPECT_NEAR(c.tangent_n_per_m(c.cut_depth_m), 2000.0 - share * 1000.0, 1e-9);
        for (int i = 1; i <= 10; ++i) {
            EXPECT_GE(c.force_n(c.cut_depth_m * i / 10), c.force_n(c.cut_depth_m * (i - 1) / 10));
        }
    }
}

TEST(Tenting, BoneIsAPlainSpring) {
    const TentingCurve c = tentingCurve({HUGE_VAL, 3.0, 2000.0, false, patient::Role::risk}, 0.7, 0.5);
    EXPECT_DOUBLE_EQ(c.force_n(0.005), 0.7 + 10.0);
    EXPECT_TRUE(std::isinf(c.cut_depth_m));
}

TEST(Tenting, AirHasNeitherTentingNorFriction) {
    const patient::TissueRow air{};
    EXPECT_FALSE(resists(air, -1.0));
    EXPECT_EQ(clampToFriction(air, 2.0, 1.0), 0.0);
}

TEST(Tenting, FrictionEqualToTheThresholdDoesNotTent) {
    const patient::TissueRow soft{0.7, 0.7, 1000.0, false, patient::Role::pass};
    EXPECT_FALSE(resists(soft, 1200.0 * (0.7 / 1200.0)));
    EXPECT_FALSE(resists(soft, 0.7 - 0.9e-6));
    EXPECT_TRUE(resists(soft, 0.7 - 1.1e-6));
}

}  // namespace
}  // namespace stylet::haptics
