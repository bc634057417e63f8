#include "patient/motion/interruption.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/constants.h"

namespace stylet::patient {
namespace {

using test::kDt_s;

struct BreathingModel {
    BreathPlan plan{.rhythm = {4.0, 0.9}};
    BreathingState breathing{};
    Interruption over{};
    Surrogate step() {
        stepBreathing(breathing, plan, kDt_s);
        stepInterruption(over, plan, kDt_s);
        Surrogate now = surrogateAt(breathing, plan, kDt_s);
        const Surrogate added = interruptionAt(over, plan, kDt_s);
        now.v += added.v, now.rate_per_s += added.rate_per_s;
        return now;
    }
};

double hump(double t_s, double length_s, double height) {
    const double s = t_s > 0.0 && t_s < length_s ? std::sin(std::numbers::pi * t_s / length_s) : 0.0;
    return height * s * s * s * s;
}

// The interruption adds a hump of known shape to the breath. Before and after it the breath is unchanged.
TEST(Interruption, IsAddedToTheBreath) {
    for (const InterruptionKind kind : {InterruptionKind::cough, InterruptionKind::sigh}) {
        BreathingModel plain, interrupted;
        for (int i = 0; i < 700; ++i)
            plain.step(), interrupted.step();
        interrupt(interrupted.over, interrupted.breathing, interrupted.plan, kind);
        double most_v = 0.0;
        Surrogate last = interrupted.breathing.held
                             ? Surrogate{}
                             : surrogateAt(interrupted.breathing, interrupted.plan, kDt_s);
        for (int i = 1; i <= 7000; ++i) {
            const Surrogate base = plain.step(), now = interrupted.step();
            if (i == 1000)
                interrupt(interrupted.over, interrupted.breathing, interrupted.plan, InterruptionKind::cough);
            const double t_s = i * kDt_s;
            double over = hump(t_s, 1.4 * 4.0, 0.8 * 0.9);
            if (kind == InterruptionKind::cough) {
                over = hump(t_s, 1.2, 0.5 * 0.9);
                for (int burst = 0; burst < 3; ++burst)
                    over += hump(t_s - 1.2 - 0.4 * burst, 0.4, 0.2 * 0.9);
            }
            ASSERT_NEAR(now.v - base.v, over, 1e-9) << i;
            ASSERT_LT(std::fabs(now.v - last.v), 0.004) << i;  // no jump
            ASSERT_NEAR((now.v - last.v) / kDt_s, 0.5 * (now.rate_per_s + last.rate_per_s), 2e-3) << i;
            last = now, most_v = std::max(most_v, over);
        }
        EXPECT_GT(most_v, 0.4);
        EXPECT_EQ(interrupted.over.kind, InterruptionKind::none);
    }
}

TEST(Interruption, EndsAHoldWithoutAJump) {
    BreathPlan recorded{.rhythm = {4.0, 1.0}};
    for (int i = 0; i < 120; ++i)
        recorded.recording_v.push_back(0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * i / 40));
    for (const BreathPlan& plan : {BreathPlan{.rhythm = {4.0, 1.0}}, recorded})
        for (const InterruptionKind kind : {InterruptionKind::cough, InterruptionKind::sigh}) {
            BreathingModel subject{plan};
            commandHold(subject.breathing, true);
            for (int i = 0; i < 20000 && !subject.breathing.held; ++i)
                subject.step();
            ASSERT_TRUE(subject.breathing.held);
            Surrogate last = subject.step();
            interrupt(subject.over, subject.breathing, plan, kind);
            double most_v = 0.0;
            for (int i = 0; i < 2500; ++i) {
                const Surrogate now = subject.step();
                EXPECT_LT(std::fabs(now.v - last.v), 0.006) << i;
                last = now, most_v = std::max(most_v, now.v);
            }
            EXPECT_FALSE(subject.breathing.held);
            EXPECT_TRUE(subject.breathing.hold_aborted);
            EXPECT_GT(most_v, 0.3);
        }
}

}  // namespace
}  // namespace stylet::patient
