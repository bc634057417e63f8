#include "haptics/output/passivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/constants.h"

namespace stylet::haptics {
namespace {

using test::kDt_s;

constexpr double kSteep_n_per_m = 0.25 * 0.1 / (kDt_s * kDt_s);  // for 0.1 kg, as in the output stage

// A spring that pulls toward x = 0 along the x axis, sampled and held. Observed and corrected as in the
// output stage.
struct SampledSpring {
    // Starts as if already in motion, so that the first motion is not spread over ticks at rest.
    explicit SampledSpring(double k = 1000.0) : stiffness_n_per_m(k) {
        step(0.0);
        state.still = {};
    }

    double stiffness_n_per_m, scale = 1.0;
    bool controlled = true;
    int delay_ticks = 0;
    PassivityState state;
    double x_m = 0.0, tissue_m = 0.0;
    double controller_n = 0.0;

    // Returns the force sent after tip and tissue have moved.
    double step(double x, double tissue = 0.0) {
        Motion m;
        m.tip_moved_m.x = x - x_m;
        m.tissue_moved_m.x = tissue - tissue_m;
        x_m = x, tissue_m = tissue;
        const double e = x_m - tissue_m;
        m.model_n.x = -stiffness_n_per_m * e;
        m.energy_j = 0.5 * stiffness_n_per_m * e * e;
        observe(state, m, delay_ticks);
        controller_n =
            controlled ? dissipate(state, m, delay_ticks, kSteep_n_per_m / (1 + delay_ticks)).x : 0.0;
        recordSentForce(state, {Vec3(scale * m.model_n.x + controller_n, 0.0, 0.0),
                                Vec3(0.0),
                                scale,
                                1.0,
                                {controller_n, 0.0, 0.0}});
        return state.sent[state.newest].force_n.x;
    }
};

TEST(Passivity, ControllerLeadsASpringByHalfATick) {
    SampledSpring spring;
    const double dx = 20e-6;
    for (int i = 1; i <= 50; ++i) {
        spring.step(i * dx);
        EXPECT_NEAR(spring.state.excess_energy_j, kMargin * 0.5 * 1000.0 * dx * dx, 1e-18);
        EXPECT_NEAR(spring.controller_n, -kMargin * 0.5 * 1000.0 * dx, 1e-12);
    }
    // On the way back the damping changes sign. The excess energy of the turn is dissipated within two ticks.
    for (int i = 49; i >= 0; --i)
        spring.step(i * dx);
    EXPECT_NEAR(spring.controller_n, kMargin * 0.5 * 1000.0 * dx, 1e-12);
    EXPECT_NEAR(spring.state.excess_energy_j, kMargin * 0.5 * 1000.0 * dx * dx, 1e-18);
}

// Moves in and out again. Returns the energy that the hand gains.
double gained(SampledSpring spring, int ticks, double depth_m) {
    double gained_j = 0.0, x = 0.0, force_n = 0.0;
    for (int i = 0; i <= 2 * ticks; ++i) {
        const double next = depth_m * (i <= ticks ? i : 2 * ticks - i) / ticks;
        gained_j += force_n * (next - x);
        x = next;
        force_n = spring.step(x);
    }
    return gained_j;
}

// HZ-FORCE-09
TEST(Passivity, SpringReturnsNoMoreEnergyThanItReceived) {
    const double depth = 0.005;
    SampledSpring off;
    off.controlled = false;
    for (const int ticks : {5, 20, 250}) {
        const double dx = depth / ticks;
        EXPECT_NEAR(gained(off, ticks, depth), 1000.0 * dx * dx * ticks, 1e-12);
        // The remaining gain comes from the first tick, which is unpredictable, and from the turn, which
        // could be an encoder edge crossed twice.
        EXPECT_LT(gained(SampledSpring(), ticks, depth), 1.6 * 1000.0 * dx * dx);
    }
}

// A bare mass on the spring, integrated exactly between ticks. Returns the amplitude after `ticks`, from 1
// mm.
double amplitude(SampledSpring spring, double mass_kg, int ticks) {
    double x = 0.001, v = 0.0, most = 0.0;
    std::vector<double> queue(std::size_t(spring.delay_ticks + 1), 0.0);
    for (int i = 0; i < ticks; ++i) {
        queue.push_back(spring.step(x));
        const double a = queue[queue.size() - 1 - std::size_t(spring.delay_ticks)] / mass_kg;
        x += v * kDt_s + 0.5 * a * kDt_s * kDt_s;
        v += a * kDt_s;
        if (i > ticks - 200) most = std::max(most, std::fabs(x));
    }
    return most;
}

// HZ-FORCE-09
TEST(Passivity, ABareMassOnASpringComesToRest) {
    for (const double stiffness : {200.0, 1000.0, 2000.0}) {
        SampledSpring spring(stiffness);
        EXPECT_LT(amplitude(spring, 0.1, 5000), 0.0011) << stiffness;
        spring.controlled = false;
        EXPECT_GT(amplitude(spring, 0.1, 5000), 0.01) << stiffness;  // K T / 2 of negative damping
    }
}

TEST(Passivity, AKnownDelayIsAccountedFor) {
    SampledSpring off(500.0), told(500.0);
    off.controlled = false;
    told.delay_ticks = 2;
    // The same delayed device, without and with a controller that knows the delay.
    const auto late = [](SampledSpring s) {
        double x = 0.001, v = 0.0, most = 0.0, before = 0.0, now = 0.0;
        for (int i = 0; i < 5000; ++i) {
            const double next = s.step(x);
            x += v * kDt_s + 0.5 * before / 0.2 * kDt_s * kDt_s;
            v += before / 0.2 * kDt_s;
            before = now, now = next;
            if (i > 4800) most = std::max(most, std::fabs(x));
        }
        return most;
    };
    EXPECT_GT(late(off), 0.01);
    EXPECT_LT(late(told), 0.0011);
}

TEST(Passivity, ARestingHandFeelsTheBreathUndamped) {
    // The tissue moves by 1 mm at 0.25 Hz, within the spring's reach. The controller adds half a tick of
    // that motion.
    SampledSpring on, off;
    off.controlled = false;
    double most_n = 0.0, difference_n = 0.0;
    for (int i = 0; i < 8000; ++i) {
        const double tissue = 0.0005 * (1.0 - std::cos(2.0 * 3.14159265358979 * 0.25 * i * kDt_s));
        const double with = on.step(0.0, tissue), without = off.step(0.0, tissue);
        most_n = std::max(most_n, std::fabs(without));
        difference_n = std::max(difference_n, std::fabs(with - without));
    }
    EXPECT_NEAR(most_n, 1.0, 1e-6);
    EXPECT_LT(difference_n, 1.01 * kMargin * 0.5 * 1000.0 * 0.0005 * 2.0 * 3.14159265358979 * 0.25 * kDt_s);
}

TEST(Passivity, GainScalesTheExcessEnergy) {
    SampledSpring half;
    half.scale = 0.5;
    for (int i = 1; i <= 10; ++i)
        half.step(i * 1e-5);
    EXPECT_NEAR(half.state.excess_energy_j, kMargin * 0.5 * 0.5 * 1000.0 * 1e-10, 1e-18);
}

TEST(Passivity, ForceRampCreatesNoExcessEnergy) {
    SampledSpring ramped;
    ramped.step(0.001);
    const double owed = ramped.state.excess_energy_j;
    for (int i = 0; i <= 1000; ++i) {
        ramped.scale = 1.0 - i / 1000.0;
        ramped.step(0.001);
    }
    for (int i = 0; i <= 1000; ++i) {
        ramped.scale = i / 1000.0;
        ramped.step(0.001);
    }
    EXPECT_EQ(ramped.state.excess_energy_j, owed);
}

// One tick of a force against an advance of 0.1 mm.
Motion rubbing(double force_n, double energy_j) {
    Motion m;
    m.tip_moved_m.x = 1e-4;
    m.model_n.x = -force_n;
    m.energy_j = energy_j;
    return m;
}

TEST(Passivity, FrictionCreatesNeitherExcessNorReserve) {
    PassivityState s;
    for (int i = 0; i < 1000; ++i) {
        observe(s, rubbing(0.9, 0.9 * 0.9 / 2400.0), 0);
        if (i > 0) {
            EXPECT_EQ(s.excess_energy_j, 0.0);
        } else {
            s.excess_energy_j = 0.0;  // the springs start loaded
        }
        recordSentForce(s, {{-0.9, 0.0, 0.0}, Vec3(0.0), 1.0, 1.0});
    }
    // 0.09 J were dissipated. A single tick that generates 10 uJ is still detected.
    Motion active = rubbing(0.9, 0.9 * 0.9 / 2400.0);
    active.tip_moved_m.x = -1e-5;
    s.sense = {};  // no encoder edge before it
    observe(s, active, 0);
    EXPECT_NEAR(s.excess_energy_j, kMargin * 0.9e-5, 1e-12);
    EXPECT_NEAR(dissipate(s, active, 0, 1e9).x, kMargin * 0.9, 1e-9);
    EXPECT_NEAR(dissipate(s, active, 0, 1000.0).x, 0.01, 1e-12);  // bounded
}

TEST(Passivity, PunctureCreatesNoReserveAndARiseOfTheSpringsEnergyIsExcess) {
    PassivityState s;
    const double full_j = 0.003;
    observe(s, rubbing(2.5, full_j), 0);
    s.excess_energy_j = 2e-6;
    recordSentForce(s, {{-2.5, 0.0, 0.0}, Vec3(0.0), 1.0, 1.0});
    Motion cut = rubbing(0.9, 0.9 * 0.9 / 2400.0);
    cut.tip_moved_m.x = 0.0;
    cut.event = true;
    observe(s, cut, 0);
    EXPECT_EQ(s.excess_energy_j, 2e-6);  // 2.6 mJ went into the tissue

    s = {};
    observe(s, {}, 0);
    s.still = {};
    recordSentForce(s, {{-0.7, 0.0, 0.0}, Vec3(0.0), 1.0, 1.0});
    s.model_n.x = -0.7, s.energy_j = 0.49 / 2400.0;
    Motion softer = rubbing(0.7, 0.49 / 2000.0);
    softer.tip_moved_m.x = 0.0;
    for (const bool event : {true, false}) {
        s.energy_j = 0.49 / 2400.0;
        s.excess_energy_j = 0.0;
        softer.event = event;
        observe(s, softer, 0);
        EXPECT_NEAR(s.excess_energy_j, kMargin * (0.49 / 2000.0 - 0.49 / 2400.0), 1e-12);
    }
}

// HZ-FORCE-19
TEST(Passivity, WallWorkUsesTipMotionNotTissueMotion) {
    PassivityState s;
    Motion m;
    m.tissue_moved_m.x = 1e-3;
    m.tip_moved_m.x = 1e-4;
    recordSentForce(s, {{-1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, 1.0, 1.0});
    m.wall_energy_j = 1.5e-4;
    observe(s, m, 0);
    EXPECT_NEAR(s.excess_energy_j, kMargin * 0.5e-4, 1e-15);
}

// A spring behind a coarse encoder. With steady motion, the controller dissipates as much energy as without
// the encoder, apart from the margin, and as steadily.
TEST(Passivity, CountAfterStillTicksIsSpreadOverThem) {
    const double step = 2e-6, count = 20e-6;
    for (const int delay : {0, 3}) {
        SampledSpring fine, coarse;
        fine.delay_ticks = coarse.delay_ticks = delay;
        double most_n = 0.0, sum_n = 0.0, fine_sum_n = 0.0;
        for (int i = 1; i <= 1000; ++i) {
            fine.step(i * step);
            coarse.step(std::floor(i * step / count) * count);
            if (i <= 500) continue;
            most_n = std::max(most_n, -coarse.controller_n);
            sum_n -= coarse.controller_n;
            fine_sum_n -= fine.controller_n;
        }
        EXPECT_GT(sum_n / fine_sum_n, 1.0) << delay;
        EXPECT_LT(sum_n / fine_sum_n, kSlowMargin / kMargin) << delay;
        EXPECT_LT(most_n, 3.5 * fine_sum_n / 500) << delay;
    }
}

// The position toggles between two counts forever. The excess energy must not accumulate.
TEST(Passivity, TogglingCountAccumulatesNoExcess) {
    for (const int every : {1, 2, 7, 60}) {
        SampledSpring spring;
        spring.step(0.001);
        spring.state.excess_energy_j = 0.0;
        for (int i = 0; i < 100000; ++i)
            spring.step(0.001 + (i / every % 2 == 0 ? 0.0 : 30e-6));
        EXPECT_LT(spring.state.excess_energy_j, 2.0 * 1000.0 * 30e-6 * 30e-6) << every;
        EXPECT_LT(std::fabs(spring.controller_n), 0.1) << every;
    }
}

TEST(Passivity, ForceIsZeroWithoutMotion) {
    PassivityState s;
    s.excess_energy_j = 1.0;
    EXPECT_EQ(dissipate(s, {}, 0, kSteep_n_per_m), Vec3(0.0));
}

}  // namespace
}  // namespace stylet::haptics
