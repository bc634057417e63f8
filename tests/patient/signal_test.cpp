#include "patient/motion/signal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <set>

#include "base/hash.h"
#include "tests/support/constants.h"

namespace stylet::patient {
namespace {

using test::kDt_s;

BreathPlan regular(double period_s, double amplitude) {
    return {.rhythm = {period_s, amplitude}};
}

BreathPlan restless(std::uint64_t seed) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.period_jitter = plan.depth_jitter = 0.12;
    plan.sighs = 0.05;
    plan.coughs = 0.05;
    plan.hold = {.creep_v = -0.3, .missed = 0.3, .level_v = 0.1, .limit_s = 8.0};
    plan.seed = seed;
    return plan;
}

// A recording of whole sine periods, so that every value is known.
BreathPlan recordedSine(double period_s, int periods) {
    BreathPlan plan = regular(4.0, 1.0);
    const int samples = int(period_s / plan.recording_dt_s + 0.5);
    for (int i = 0; i < periods * samples; ++i)
        plan.recording_v.push_back(0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * i / samples));
    return plan;
}

void run(BreathingState& state, const BreathPlan& plan, int ticks,
         const std::function<void(const Surrogate&)>& each = {}) {
    for (int i = 0; i < ticks; ++i) {
        stepBreathing(state, plan, kDt_s);
        if (each) each(surrogateAt(state, plan, kDt_s));
    }
}

// Returns the number of ticks until the hold begins, but at most `most`.
int ticksUntilHold(BreathingState& state, const BreathPlan& plan, int most = 60000) {
    for (int i = 1; i <= most; ++i) {
        stepBreathing(state, plan, kDt_s);
        if (state.held) return i;
    }
    return -1;
}

TEST(RegularSignal, IsTheFourthPowerOfASine) {
    const BreathPlan plan = regular(4.0, 0.8);
    BreathingState state;
    EXPECT_EQ(surrogateAt(state, plan, kDt_s), Surrogate{});
    int i = 0, below = 0;
    run(state, plan, 8000, [&](const Surrogate& s) {
        const double angle = std::numbers::pi * (++i % 4000) / 4000.0;
        ASSERT_NEAR(s.v, 0.8 * std::pow(std::sin(angle), 4), 1e-14);
        ASSERT_NEAR(s.rate_per_s, 0.8 * std::numbers::pi * std::pow(std::sin(angle), 3) * std::cos(angle),
                    1e-13);
        ASSERT_EQ(s.creep_v, 0.0);
        below += s.v < 0.4;
    });
    // More than half of the cycle is below half of the travel: the exhale is the longer part.
    EXPECT_GT(below, 5000);
}

TEST(RegularSignal, PhaseIsCountedNotSummed) {
    const BreathPlan plan = regular(4.0, 1.0);
    BreathingState state;
    run(state, plan, 4000 * 25);
    EXPECT_EQ(state.phase_ticks, 0u);
    EXPECT_EQ(state.breath, 26u);
}

TEST(Hold, TakesEffectAtEndExhaleAndResumesThere) {
    const BreathPlan plan = regular(4.0, 1.0);
    BreathingState state;
    run(state, plan, 1500);
    commandHold(state, true);
    EXPECT_EQ(ticksUntilHold(state, plan), 2500);
    run(state, plan, 5000, [](const Surrogate& s) { ASSERT_EQ(s, Surrogate{}); });
    commandHold(state, false);
    stepBreathing(state, plan, kDt_s);
    EXPECT_FALSE(state.held);
    EXPECT_EQ(state.phase_ticks, 1u);
}

TEST(Hold, IsImmediateAtEndExhaleAndMayBeRevoked) {
    const BreathPlan plan = regular(4.0, 1.0);
    BreathingState state;
    commandHold(state, true);
    EXPECT_EQ(ticksUntilHold(state, plan), 1);
    state = {};
    run(state, plan, 100);
    commandHold(state, true);
    run(state, plan, 100);
    commandHold(state, false);
    run(state, plan, 8000, [&](const Surrogate&) { ASSERT_FALSE(state.held); });
}

TEST(Hold, CreepsLinearlyStopsAndEasesOffWithoutAJump) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.hold.creep_v = -0.28;  // 5.6 mm of 20 mm
    BreathingState state;
    commandHold(state, true);
    ASSERT_EQ(ticksUntilHold(state, plan), 1);
    run(state, plan, 12000);
    EXPECT_NEAR(surrogateAt(state, plan, kDt_s).creep_v, -0.14, 1e-12);
    run(state, plan, 12000);
    EXPECT_NEAR(surrogateAt(state, plan, kDt_s).creep_v, -0.28, 1e-12);
    run(state, plan, 6000);
    EXPECT_EQ(surrogateAt(state, plan, kDt_s).creep_v, -0.28);
    EXPECT_EQ(surrogateAt(state, plan, kDt_s).v, 0.0);

    commandHold(state, false);
    double last_v = -0.28;
    run(state, plan, 1000, [&](const Surrogate& s) {
        ASSERT_GE(s.creep_v, last_v);
        ASSERT_LT(s.creep_v - last_v, 0.0004);
        last_v = s.creep_v;
    });
    // Hold again before the creep has decayed: the creep continues from its current value.
    state.phase_ticks = state.now.ticks - 1;
    commandHold(state, true);
    ASSERT_EQ(ticksUntilHold(state, plan), 1);
    EXPECT_NEAR(surrogateAt(state, plan, kDt_s).creep_v, last_v, 0.0004);
    run(state, plan, 24000);
    EXPECT_NEAR(surrogateAt(state, plan, kDt_s).creep_v, -0.28, 1e-12);
    commandHold(state, false);
    run(state, plan, 1600);
    EXPECT_EQ(surrogateAt(state, plan, kDt_s).creep_v, 0.0);
}

TEST(Compliance, HoldsAboveEndExhaleThenSighsAndObeysANewCommand) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.hold.level_v = 0.2;
    plan.hold.limit_s = 10.0;
    plan.seed = 3;
    BreathingState state;
    run(state, plan, 100);
    commandHold(state, true);
    EXPECT_EQ(ticksUntilHold(state, plan), 3900);
    const double level_v = surrogateAt(state, plan, kDt_s).v;
    EXPECT_GT(level_v, 0.0);
    EXPECT_LT(level_v, 0.2);
    int held = 0;
    while (state.held && held < 20000)
        stepBreathing(state, plan, kDt_s), ++held;
    EXPECT_GE(held, 8000);
    EXPECT_LE(held, 12000);
    double most_v = 0.0;
    run(state, plan, 20000, [&](const Surrogate& s) {
        ASSERT_FALSE(state.held);  // the command is still active, but the patient breathes
        most_v = std::max(most_v, s.v);
    });
    EXPECT_NEAR(most_v, 1.8, 1e-6);
    commandHold(state, true);
    EXPECT_GT(ticksUntilHold(state, plan), 0);
}

TEST(Compliance, MissesTheStatedShareOfEndExhales) {
    BreathPlan plan = regular(0.6, 1.0);
    plan.hold.missed = 0.4;
    int missed = 0, held = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        plan.seed = seed;
        BreathingState state;
        run(state, plan, 1);
        commandHold(state, true);
        const int ticks = ticksUntilHold(state, plan);
        ASSERT_EQ((ticks + 1) % 600, 0);
        missed += (ticks + 1) / 600 - 1, ++held;
    }
    EXPECT_NEAR(double(missed) / (missed + held), 0.4, 0.05);
}

TEST(Compliance, ACoughEndsAHold) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.coughs = 1.0;
    BreathingState state;
    commandHold(state, true);
    ASSERT_EQ(ticksUntilHold(state, plan), 1);
    int held = 0;
    while (state.held && held < 20000)
        stepBreathing(state, plan, kDt_s), ++held;
    EXPECT_GE(held, 2000);
    EXPECT_LE(held, 6000);
    double most_v = 0.0;
    run(state, plan, 1200, [&](const Surrogate& s) { most_v = std::max(most_v, s.v); });
    EXPECT_NEAR(most_v, 0.9, 1e-6);
    EXPECT_EQ(state.bursts_left, 2u);
}

TEST(IrregularSignal, VariesByTheGivenJitter) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.period_jitter = 0.10;
    plan.depth_jitter = 0.15;
    BreathingState state;
    double period = 0.0, period2 = 0.0, depth = 0.0, depth2 = 0.0;
    const int n = 1000;
    std::set<std::uint64_t> lengths;
    run(state, plan, 1);
    for (int i = 0; i < n; ++i) {
        const double p_s = double(state.now.ticks) * kDt_s, d_v = state.now.peak_v;
        lengths.insert(state.now.ticks);
        period += p_s, period2 += p_s * p_s, depth += d_v, depth2 += d_v * d_v;
        run(state, plan, int(state.now.ticks));
    }
    period /= n, depth /= n;
    EXPECT_NEAR(period, 4.0, 0.05);
    EXPECT_NEAR(std::sqrt(period2 / n - period * period) / period, 0.10, 0.01);
    EXPECT_NEAR(depth, 1.0, 0.02);
    EXPECT_NEAR(std::sqrt(depth2 / n - depth * depth) / depth, 0.15, 0.01);
    EXPECT_GT(lengths.size(), 400u);
}

// Checks that v has no jumps and that `rate` is its derivative, through jitter, sighs, coughs, holds, creep
// and aborted holds.
void expectSmooth(const BreathPlan& plan, double fastest_per_s) {
    BreathingState state;
    Surrogate before;
    double sum_v = 0.0;
    for (int i = 0; i < 300000; ++i) {
        if (i % 30000 == 11000) commandHold(state, true);
        if (i % 30000 == 24000) commandHold(state, false);
        stepBreathing(state, plan, kDt_s);
        const Surrogate now = surrogateAt(state, plan, kDt_s);
        ASSERT_TRUE(std::isfinite(now.v + now.rate_per_s + now.creep_v));
        ASSERT_LE(std::fabs(now.rate_per_s), fastest_per_s);
        ASSERT_NEAR(now.v - before.v, 0.5 * kDt_s * (now.rate_per_s + before.rate_per_s), 2e-5) << i;
        ASSERT_NEAR(now.creep_v, before.creep_v, 0.0005);
        sum_v += std::fabs(now.v - before.v);
        before = now;
    }
    EXPECT_GT(sum_v, 50.0);
}

// HZ-FORCE-04
TEST(IrregularSignal, NeverJumps) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed)
        expectSmooth(restless(seed), 5.0);
}

TEST(IrregularSignal, SighsAndCoughsComeAtTheirRate) {
    BreathPlan plan = regular(4.0, 1.0);
    plan.sighs = 0.1;
    plan.coughs = 0.05;
    BreathingState state;
    int sighs = 0, coughs = 0;
    for (int breaths = 0; breaths < 3000; ++breaths) {
        stepBreathing(state, plan, kDt_s);
        sighs += state.now.peak_v > 1.5;
        coughs += state.bursts_left == 3;
        while (!state.at_end_exhale)
            stepBreathing(state, plan, kDt_s);
    }
    EXPECT_NEAR(sighs / 3000.0, 0.1, 0.02);
    EXPECT_NEAR(coughs / 3000.0, 0.05, 0.015);
}

TEST(AnySignal, DependsOnlyOnTheSeed) {
    const auto play = [](const BreathPlan& plan) {
        BreathingState state;
        StateHash hash;
        for (int i = 0; i < 60000; ++i) {
            if (i == 20000 || i == 40000) commandHold(state, i == 20000);
            stepBreathing(state, plan, kDt_s);
            hashBreathing(hash, state);
            hash.add(surrogateAt(state, plan, kDt_s).v);
        }
        return hash.value();
    };
    // Equal on every compiler, build type and machine. Update only after an intended change.
    EXPECT_EQ(play(restless(7)), 0x6a404e362b425c9aull);
    EXPECT_EQ(play(restless(7)), play(restless(7)));
    EXPECT_NE(play(restless(7)), play(restless(8)));
}

TEST(AnySignal, EveryPartOfThePlanIsHashed) {
    const auto computeHash = [](const BreathPlan& plan) {
        StateHash hash;
        hashPlan(hash, plan);
        return hash.value();
    };
    const BreathPlan plan = recordedSine(4.0, 2);
    std::set<std::uint64_t> hashes{computeHash(plan)};
    const std::vector<std::function<void(BreathPlan&)>> changes = {
        [](BreathPlan& p) { p.rhythm.period_s = 5.0; },
        [](BreathPlan& p) { p.rhythm.amplitude = 0.9; },
        [](BreathPlan& p) { p.period_jitter = 0.1; },
        [](BreathPlan& p) { p.depth_jitter = 0.1; },
        [](BreathPlan& p) { p.sighs = 0.1; },
        [](BreathPlan& p) { p.coughs = 0.1; },
        [](BreathPlan& p) { p.hold.creep_v = -0.1; },
        [](BreathPlan& p) { p.hold.creep_s = 20.0; },
        [](BreathPlan& p) { p.hold.missed = 0.1; },
        [](BreathPlan& p) { p.hold.level_v = 0.1; },
        [](BreathPlan& p) { p.hold.limit_s = 9.0; },
        [](BreathPlan& p) { p.seed = 1; },
        [](BreathPlan& p) { p.recording_v[3] += 1e-12; },
        [](BreathPlan& p) { p.recording_dt_s = 0.2; },
        [](BreathPlan& p) { p.recording_v.pop_back(); }};
    for (const auto& change : changes) {
        BreathPlan other = plan;
        change(other);
        hashes.insert(computeHash(other));
    }
    EXPECT_EQ(hashes.size(), changes.size() + 1);
}

TEST(RecordedSignal, RunsThroughItsSamplesAroundTheLoop) {
    const BreathPlan plan = recordedSine(5.0, 2);
    BreathingState state;
    int i = 0;
    run(state, plan, 25000, [&](const Surrogate& s) {
        const double angle = 2.0 * std::numbers::pi * ++i * kDt_s / 5.0;
        ASSERT_NEAR(s.v, 0.5 - 0.5 * std::cos(angle), 2e-5);
        ASSERT_NEAR(s.rate_per_s, std::numbers::pi / 5.0 * std::sin(angle), 3e-3);
        if (i % 100 != 0) return;
        ASSERT_NEAR(s.v, plan.recording_v[std::size_t(i / 100) % 100], 1e-13);
    });
    expectSmooth(plan, 0.64);
}

TEST(RecordedSignal, IsHeldAtItsOwnEndExhale) {
    BreathPlan plan = recordedSine(5.0, 3);
    BreathingState state;
    run(state, plan, 1000);
    commandHold(state, true);
    EXPECT_NEAR(ticksUntilHold(state, plan), 4000, 1);
    run(state, plan, 3000, [](const Surrogate& s) {
        ASSERT_NEAR(s.v, 0.0, 1e-6);
        ASSERT_EQ(s.rate_per_s, 0.0);
    });
    commandHold(state, false);
    run(state, plan, 2500);
    EXPECT_NEAR(surrogateAt(state, plan, kDt_s).v, 1.0, 1e-5);
}

TEST(AnySignal, CompliantPatientHoldsWithinTheLongestBreath) {
    EXPECT_DOUBLE_EQ(longestBreath_s(regular(4.0, 1.0), kDt_s), 4.0);
    EXPECT_NEAR(longestBreath_s(recordedSine(5.0, 3), kDt_s), 5.0, 0.002);
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        BreathPlan plan = restless(seed);
        plan.hold.missed = 0.0;
        BreathingState state;
        run(state, plan, 1 + int(seed) * 777);
        commandHold(state, true);
        ASSERT_LE(ticksUntilHold(state, plan) * kDt_s, longestBreath_s(plan, kDt_s));
    }
}

}  // namespace
}  // namespace stylet::patient
