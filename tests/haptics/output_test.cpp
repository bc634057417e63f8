#include "haptics/output.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDt_s = 0.001;

// Settings whose gain is 1.
OutputSettings plain() {
    OutputSettings s;
    s.model_tangent_n_per_m = 1000.0;
    return s;
}

// Liver, 1.2 N/mm, is steepest at its cut unless a1 = k; bone, 2 N/mm, is a plain spring.
TEST(Output, TheTangentIsTheSteepestOfTheTable) {
    const patient::TissueTable table = test::tissueDefaults().tissues;
    EXPECT_DOUBLE_EQ(worstTangent(table, {.a1_share = 0.0}), 2400.0);
    EXPECT_DOUBLE_EQ(worstTangent(table, {.a1_share = 0.5}), 2000.0);
}

TEST(Output, TheGainIsTheSmallestOfItsThreeBounds) {
    OutputSettings s;
    s.model_tangent_n_per_m = 2000.0;
    s.model_force_n = 22.0;
    EXPECT_DOUBLE_EQ(outputGain({"stiff", 22.0, 4000.0, ""}, s), 1.0);
    EXPECT_DOUBLE_EQ(outputGain({"soft", 22.0, 1000.0, ""}, s), 0.5);
    EXPECT_DOUBLE_EQ(outputGain({"weak", 3.3, 4000.0, ""}, s), 0.15);
    EXPECT_DOUBLE_EQ(outputGain({"unknown", kNan, kNan, ""}, s), 3.3 / 22.0);
}

TEST(Output, TheRateLimitIsReachedAndHeld) {
    OutputState state;
    const Vec3 wanted{3.0, 4.0, 0.0};
    Vec3 sent = stepOutput(state, plain(), {}, 1.0, wanted, kDt_s);
    EXPECT_NEAR(sent.x, 1.2, 1e-12);  // 2 N of the 5 along the way
    EXPECT_NEAR(sent.y, 1.6, 1e-12);
    EXPECT_TRUE(state.limited);
    stepOutput(state, plain(), {}, 1.0, wanted, kDt_s);
    sent = stepOutput(state, plain(), {}, 1.0, wanted, kDt_s);
    EXPECT_EQ(sent, wanted);
    EXPECT_FALSE(state.limited);
}

TEST(Output, ThePunctureOfAFasciaPassesInOneTick) {
    OutputState state;
    state.model_n = {2.5, 0.0, 0.0};
    EXPECT_EQ(stepOutput(state, plain(), {}, 1.0, {0.9, 0.0, 0.0}, kDt_s).x, 0.9);
}

TEST(Output, GainThenDeviceClamp) {
    OutputState state;
    const DeviceProfile touch{.name = "touch", .force_peak_n = 3.3, .stiffness_n_per_m = 400.0};
    state.model_n = {0.0, 20.0, 0.0};
    EXPECT_NEAR(stepOutput(state, plain(), touch, 0.1, {0.0, 20.0, 0.0}, kDt_s).y, 2.0, 1e-12);
    EXPECT_NEAR(stepOutput(state, plain(), touch, 0.5, {0.0, 20.0, 0.0}, kDt_s).y, 3.3, 1e-12);
    EXPECT_TRUE(state.limited);
    state.model_n = {0.0, 30.0, 0.0};  // beyond the model's own largest force
    EXPECT_NEAR(stepOutput(state, plain(), {"strong", 100.0, 1e4, ""}, 1.0, {0.0, 30.0, 0.0}, kDt_s).y, 22.0,
                1e-12);
}

TEST(Output, AForceThatIsNoNumberEndsInZeroAtTheRateLimit) {
    for (const double bad : {kNan, HUGE_VAL, -HUGE_VAL}) {
        OutputState state;
        state.model_n = {5.0, 0.0, 0.0};
        EXPECT_NEAR(stepOutput(state, plain(), {}, 1.0, {bad, 0.0, 0.0}, kDt_s).x, 3.0, 1e-12);
        EXPECT_EQ(state.faults, kFaultNotFinite);
        EXPECT_NEAR(stepOutput(state, plain(), {}, 1.0, {5.0, 0.0, 0.0}, kDt_s).x, 1.0, 1e-12);
        EXPECT_EQ(stepOutput(state, plain(), {}, 1.0, {5.0, 0.0, 0.0}, kDt_s).x, 0.0);
        EXPECT_EQ(stepOutput(state, plain(), {}, 1.0, {5.0, 0.0, 0.0}, kDt_s).x, 0.0);  // until re-armed
        state.faults = 0;
        EXPECT_NEAR(stepOutput(state, plain(), {}, 1.0, {5.0, 0.0, 0.0}, kDt_s).x, 2.0, 1e-12);
    }
}

TEST(Output, AFullRingDoesNotTakeTheForceAway) {
    OutputState state;
    state.faults = kFaultRingFull;
    EXPECT_EQ(stepOutput(state, plain(), {}, 1.0, {1.0, 0.0, 0.0}, kDt_s).x, 1.0);
}

}  // namespace
}  // namespace stylet::haptics
