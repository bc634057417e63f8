#include "patient/signal.h"

#include <gtest/gtest.h>

namespace stylet::patient {
namespace {

constexpr double kDt_s = 0.001;

TEST(BreathingSignal, StartsAtEndExhaleAndPeaksHalfwayThrough) {
    const BreathingSignal signal{4.0, 0.8};
    EXPECT_EQ(surrogateAt({0, false, false}, signal, kDt_s), (Surrogate{0.0, 0.0}));
    const Surrogate top = surrogateAt({2000, false, false}, signal, kDt_s);
    EXPECT_NEAR(top.v, 0.8, 1e-15);
    EXPECT_NEAR(top.rate_per_s, 0.0, 1e-12);
    // More of the cycle below half than above: the exhale is the longer part.
    int below = 0;
    for (std::uint64_t i = 0; i < 4000; ++i)
        below += surrogateAt({i, false, false}, signal, kDt_s).v < 0.4;
    EXPECT_GT(below, 2500);
}

TEST(BreathingSignal, RateIsTheDerivative) {
    const BreathingSignal signal{3.7, 0.9};
    for (std::uint64_t i = 1; i < 3699; i += 13) {
        const double before = surrogateAt({i - 1, false, false}, signal, kDt_s).v;
        const double after = surrogateAt({i + 1, false, false}, signal, kDt_s).v;
        EXPECT_NEAR(surrogateAt({i, false, false}, signal, kDt_s).rate_per_s, (after - before) / (2 * kDt_s),
                    1e-5);
    }
}

TEST(BreathingSignal, PhaseIsCountedNotSummed) {
    const BreathingSignal signal{4.0, 1.0};
    BreathingState state;
    for (int i = 0; i < 4000 * 25; ++i)
        stepBreathing(state, signal, kDt_s);
    EXPECT_EQ(state.phase_ticks, 0u);
    EXPECT_FALSE(state.held);
}

TEST(BreathingHold, TakesEffectAtEndExhaleAndResumesThere) {
    const BreathingSignal signal{4.0, 1.0};
    BreathingState state;
    for (int i = 0; i < 1500; ++i)
        stepBreathing(state, signal, kDt_s);
    state.hold_wanted = true;
    int ticks = 0;
    while (!state.held && ticks < 10000)
        stepBreathing(state, signal, kDt_s), ++ticks;
    EXPECT_EQ(ticks, 2500);
    for (int i = 0; i < 5000; ++i) {
        stepBreathing(state, signal, kDt_s);
        ASSERT_EQ(surrogateAt(state, signal, kDt_s), (Surrogate{0.0, 0.0}));
    }
    state.hold_wanted = false;
    stepBreathing(state, signal, kDt_s);
    EXPECT_FALSE(state.held);
    EXPECT_EQ(state.phase_ticks, 1u);
}

TEST(BreathingHold, IsImmediateAtEndExhaleAndMayBeRevoked) {
    const BreathingSignal signal{4.0, 1.0};
    BreathingState state;
    state.hold_wanted = true;
    stepBreathing(state, signal, kDt_s);
    EXPECT_TRUE(state.held);
    EXPECT_EQ(state.phase_ticks, 0u);
    state = {100, true, false};
    stepBreathing(state, signal, kDt_s);
    state.hold_wanted = false;
    for (int i = 0; i < 8000; ++i) {
        stepBreathing(state, signal, kDt_s);
        ASSERT_FALSE(state.held);
    }
}

}  // namespace
}  // namespace stylet::patient
