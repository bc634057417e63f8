// Tests the simulated device and hand against closed forms: a body, a spring, friction, and a sampled wall.
#include "tests/support/simulated_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptics/devices/profiles.h"
#include "tests/support/constants.h"

namespace stylet::haptics {
namespace {

using namespace test;

const Trace kResting{.samples = {{0, {}, 0}}, .commands = {}};

// Calls `force(tick, position)` and `visit(tick)` after each read.
template <typename Force, typename Visit>
void run(SimulatedDevice& device, int ticks, const Force& force, const Visit& visit) {
    for (int i = 0; i <= ticks; ++i) {
        const Vec3 read = device.read(i * kTick_ns).device_from_stylus.position_m;
        visit(i);
        device.send(force(i, read));
    }
}
const auto kNothing = [](int) {};

TEST(SimulatedDevice, AFreeBodyFollowsNewton) {
    SimulatedDevice device(kResting, {}, {.mass_kg = 0.2, .damping_n_s_per_m = 0.0});
    run(device, 1000, [](int, const Vec3&) { return Vec3(0.0, 0.1, 0.0); }, kNothing);
    EXPECT_NEAR(device.body().velocity_m_per_s.y, 0.5, 1e-12);
    EXPECT_NEAR(device.body().position_m.y, 0.25, 1e-12);
    EXPECT_NEAR(device.body().motor_work_j, 0.5 * 0.2 * 0.25, 1e-12);
    EXPECT_NEAR(device.body().motor_impulse_n_s.y, 0.1, 1e-12);
    EXPECT_EQ(device.body().dissipated_j, 0.0);
}

TEST(SimulatedDevice, DampingDissipatesKineticEnergy) {
    SimulatedDevice device(kResting, {},
                           {.mass_kg = 0.1, .damping_n_s_per_m = 0.5, .velocity_m_per_s = {0.2, 0.0, 0.0}});
    run(device, 300, [](int, const Vec3&) { return Vec3(0.0); }, kNothing);
    EXPECT_NEAR(device.body().velocity_m_per_s.x, 0.2 * std::exp(-0.5 / 0.1 * 0.3), 1e-7);
    const double v = device.body().velocity_m_per_s.x;
    EXPECT_NEAR(device.body().dissipated_j, 0.5 * 0.1 * (0.04 - v * v), 1e-12);
}

TEST(SimulatedDevice, FrictionStopsItAndHoldsIt) {
    SimulatedDevice device(
        kResting, {},
        {.mass_kg = 0.1, .damping_n_s_per_m = 0.0, .friction_n = 0.25, .velocity_m_per_s = {0.1, 0.0, 0.0}});
    run(device, 100, [](int i, const Vec3&) { return Vec3(i > 60 ? 0.24 : 0.0, 0.0, 0.0); }, kNothing);
    EXPECT_EQ(device.body().velocity_m_per_s.x, 0.0);  // at rest after 40 ms, and 0.24 N do not move it
    EXPECT_NEAR(device.body().position_m.x, 0.1 * 0.01 / (2.0 * 0.25), 5e-6);
    EXPECT_NEAR(device.body().dissipated_j, 0.5 * 0.1 * 0.01, 1e-9);
}

TEST(SimulatedDevice, TheHandYieldsLikeItsSpringAndDamper) {
    SimulatedDevice device(kResting, {}, {.mass_kg = 0.05, .damping_n_s_per_m = 0.0, .hand = kFirmHand});
    const double mass = 0.25, decay = 0.5 * 10.0 / mass, omega = std::sqrt(500.0 / mass - decay * decay);
    double worst = 0.0;
    run(
        device, 300, [](int, const Vec3&) { return Vec3(-1.0, 0.0, 0.0); },
        [&](int i) {
            const double t = i * kDt_s;
            const double swing = std::cos(omega * t) + decay / omega * std::sin(omega * t);
            const double x = -1.0 / 500.0 * (1.0 - std::exp(-decay * t) * swing);
            worst = std::max(worst, std::fabs(device.body().position_m.x - x));
        });
    EXPECT_LT(worst, 1e-7);
}

TEST(SimulatedDevice, HandReachesItsTarget) {
    Trace trace;
    trace.samples = {{0, {}, 0},
                     {1000 * kTick_ns, {{}, {0.02, 0.0, 0.0}}, 0},
                     {1500 * kTick_ns, {{}, {0.02, 0.0, 0.0}}, 7}};
    SimulatedDevice device(trace, {}, {.mass_kg = 0.05, .hand = kFirmHand});
    run(device, 900, [](int, const Vec3&) { return Vec3(0.0); }, kNothing);
    EXPECT_NEAR(device.body().position_m.x, 0.018, 2e-5);  // no lag at 20 mm/s
    EXPECT_EQ(device.read(1500 * kTick_ns).buttons, 7u);
    EXPECT_NEAR(device.body().position_m.x, 0.02, 2e-5);
}

TEST(SimulatedDevice, ReleasedHandExertsNoForce) {
    SimulatedDevice device(kResting, {},
                           {.mass_kg = 0.05, .damping_n_s_per_m = 0.0, .hand = kFirmHand, .release_s = 0.5});
    run(device, 600, [](int, const Vec3&) { return Vec3(-1.0, 0.0, 0.0); }, kNothing);
    EXPECT_NEAR(device.body().velocity_m_per_s.x, -1.0 / 0.05 * 0.1, 1e-3);  // from rest, for 0.1 s
}

TEST(SimulatedDevice, EncodersReadWholeCounts) {
    SimulatedDevice device(kResting, {},
                           {.mass_kg = 0.1, .resolution_m = 5e-5, .velocity_m_per_s = {0.013, -0.007, 0.0}});
    run(
        device, 500, [](int, const Vec3&) { return Vec3(0.0); },
        [&](int i) {
            if (i == 0) return;
            const Vec3 read = device.read(i * kTick_ns).device_from_stylus.position_m;
            for (int k = 0; k < 3; ++k) {
                const double counts = read[k] / 5e-5;
                ASSERT_NEAR(counts, std::round(counts), 1e-6);
                ASSERT_LE(std::fabs(read[k] - device.body().position_m[k]), 2.5e-5 + 1e-12);
            }
        });
}

TEST(SimulatedDevice, AForceActsAfterItsDelay) {
    SimulatedDevice device(kResting, {}, {.mass_kg = 0.1, .damping_n_s_per_m = 0.0, .delay_s = 0.0035});
    // 1 N sent at tick 10 only. It acts from 13.5 to 14.5 ms.
    run(device, 13, [](int i, const Vec3&) { return Vec3(i == 10 ? 1.0 : 0.0, 0.0, 0.0); }, kNothing);
    EXPECT_EQ(device.body().velocity_m_per_s.x, 0.0);
    device.read(14 * kTick_ns);
    EXPECT_NEAR(device.body().velocity_m_per_s.x, 0.5e-3 / 0.1, 1e-9);
    device.send(Vec3(0.0));
    device.read(30 * kTick_ns);
    EXPECT_NEAR(device.body().velocity_m_per_s.x, 1e-3 / 0.1, 1e-8);
}

TEST(SimulatedDevice, JitterIsBoundedAndReproducible) {
    const SimulatedBody body{.mass_kg = 0.1,
                             .damping_n_s_per_m = 0.0,
                             .jitter_s = 0.0004,
                             .velocity_m_per_s = {1.0, 0.0, 0.0},
                             .seed = 4};
    SimulatedDevice device(kResting, {}, body), again(kResting, {}, body);
    double earliest = 1.0, latest = 0.0, first = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const double x = device.read(i * kTick_ns).device_from_stylus.position_m.x;
        ASSERT_EQ(again.read(i * kTick_ns).device_from_stylus.position_m.x, x);
        if (i == 0) first = device.body().position_m.x;
        const double late_s = x - first - i * kDt_s;  // at 1 m/s
        earliest = std::min(earliest, late_s);
        latest = std::max(latest, late_s);
    }
    EXPECT_GT(latest - earliest, 0.00039);
    EXPECT_LE(latest - earliest, 0.0004);
}

TEST(SimulatedDevice, ForcesBeyondTheDelayBufferActEarly) {
    SimulatedDevice device(kResting, {}, {.mass_kg = 0.1, .damping_n_s_per_m = 0.0, .delay_s = 1.0});
    run(device, 500, [](int, const Vec3&) { return Vec3(1.0, 0.0, 0.0); }, kNothing);
    EXPECT_NEAR(device.body().motor_impulse_n_s.x, 0.5 - 1e-3 * SimulatedDevice::kMaxWaiting, 2e-3);
}

// A spring K with force sampled at period T and delayed by t_d lags the motion by T/2 + t_d. To first order
// this adds energy like a damper of -K (T/2 + t_d). Colgate and Schenkel 1997: b > K T/2.
struct Wall {
    double stiffness_n_per_m, damping_n_s_per_m, delay_s;
};
class SampledWall : public testing::TestWithParam<Wall> {};
INSTANTIATE_TEST_SUITE_P(Walls, SampledWall,
                         testing::Values(Wall{400.0, 0.1, 0.0}, Wall{400.0, 0.3, 0.0},
                                         Wall{1000.0, 0.005, 0.0}, Wall{1000.0, 0.9, 0.0},
                                         Wall{400.0, 0.4, 0.001}, Wall{400.0, 0.8, 0.001},
                                         Wall{400.0, 0.3, 0.0005}));

TEST_P(SampledWall, GrowsOrDecaysAsTheSampledDataTheorySays) {
    const Wall wall = GetParam();
    const double mass = 0.2;
    SimulatedDevice device(kResting, {},
                           {.mass_kg = mass,
                            .damping_n_s_per_m = wall.damping_n_s_per_m,
                            .delay_s = wall.delay_s,
                            .velocity_m_per_s = {0.05, 0.0, 0.0}});
    std::vector<double> peaks, at_s;
    double before = 0.0, last = 0.0;
    run(
        device, 400, [&](int, const Vec3& read) { return Vec3(-wall.stiffness_n_per_m * read.x, 0.0, 0.0); },
        [&](int i) {
            const double x = std::fabs(device.body().position_m.x);
            if (last > before && last > x) peaks.push_back(last), at_s.push_back((i - 1) * kDt_s);
            before = last, last = x;
        });
    ASSERT_GT(peaks.size(), 4u);
    const double growth = std::log(peaks.back() / peaks[1]) / (at_s.back() - at_s[1]);
    const double lag_s = 0.5 * kDt_s + wall.delay_s;
    const double told = (wall.stiffness_n_per_m * lag_s - wall.damping_n_s_per_m) / (2.0 * mass);
    EXPECT_NEAR(growth, told, 0.1 * std::fabs(told) + 0.1);
    EXPECT_EQ(growth > 0.0, told > 0.0);
}

TEST(SimulatedDevice, UnknownPropertiesUseTheWorstCase) {
    const SimulatedBody body = makeSimulatedBody(*findProfile("omega.3"), kLightHand);
    EXPECT_EQ(body.mass_kg, 0.045);
    EXPECT_EQ(body.damping_n_s_per_m, 0.005);
    EXPECT_EQ(body.friction_n, 0.0);
    EXPECT_EQ(body.resolution_m, 55e-6);
    EXPECT_EQ(body.hand.stiffness_n_per_m, 100.0);
    EXPECT_EQ(makeSimulatedBody(*findProfile("touch-x"), kNoHand).resolution_m, 23e-6);
}

}  // namespace
}  // namespace stylet::haptics
