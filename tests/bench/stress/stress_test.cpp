// Tests of the campaign's own measurements. A judge that never finds a failure would pass every case.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "haptics/devices/profiles.h"
#include "tests/bench/stress/stress_report.h"

namespace stylet::stress {
namespace {

TEST(LatinHypercube, SamplesEveryIntervalOfEveryColumnOnce) {
    const int count = 90;
    const std::vector<StressCase> cases = latinHypercube(count, 7);
    ASSERT_EQ(cases.size(), std::size_t(count));
    std::vector<int> tilts, depths;
    std::map<HandKind, int> hands;
    std::map<int, int> rates;
    std::map<const haptics::DeviceProfile*, int> devices;
    for (const StressCase& c : cases) {
        tilts.push_back(int((c.tilt_rad + 0.7) / 1.4 * count));
        depths.push_back(int((c.depth_m - 0.002) / 0.048 * count));
        ++hands[c.hand];
        ++rates[c.rate_hz];
        ++devices[c.device];
        EXPECT_LE(c.jitter_s * c.rate_hz, 0.4);
        EXPECT_GE(c.damping_n_s_per_m, 0.005);
        EXPECT_LE(c.damping_n_s_per_m, 0.1);
    }
    std::sort(tilts.begin(), tilts.end());
    std::sort(depths.begin(), depths.end());
    for (int i = 0; i < count; ++i) {
        EXPECT_EQ(tilts[std::size_t(i)], i);
        EXPECT_EQ(depths[std::size_t(i)], i);
    }
    EXPECT_EQ(hands[HandKind::none], count / 3);
    EXPECT_EQ(hands[HandKind::light], count / 3);
    EXPECT_EQ(rates[1000], count / 2);
    EXPECT_EQ(rates[4000], count / 6);
    EXPECT_EQ(devices.size(), haptics::deviceProfiles().size());
    const std::vector<StressCase> again = latinHypercube(count, 7), other = latinHypercube(count, 8);
    EXPECT_EQ(again[31].tilt_rad, cases[31].tilt_rad);
    EXPECT_NE(other[31].tilt_rad, cases[31].tilt_rad);
}

template <typename At>
std::vector<double> sampled(const At& at) {
    std::vector<double> x;
    for (int i = 0; i < 1000; ++i)
        x.push_back(at(i * 0.001));
    return x;
}

TEST(FindCycle, FindsAmplitudeAndFrequency) {
    const auto hum = [](double t) { return 0.0001 * std::sin(2.0 * 3.14159265 * 40.0 * t); };
    // The oscillation is superimposed on breathing and on a drifting hand.
    const Cycle cycle =
        findCycle(sampled([&](double t) { return hum(t) + 0.010 * std::sin(1.5 * t) + 0.002 * t; }), 0.001);
    EXPECT_TRUE(cycle.lasts);
    EXPECT_NEAR(cycle.amplitude_m, 0.0001, 5e-6);
    EXPECT_NEAR(cycle.hz, 40.0, 2.0);
    EXPECT_TRUE(findCycle(sampled([&](double t) { return hum(t) * std::exp(2.0 * t); }), 0.001).lasts);
}

TEST(FindCycle, IgnoresRestAndDecayingOscillations) {
    const auto hum = [](double t) { return 0.0001 * std::sin(2.0 * 3.14159265 * 40.0 * t); };
    EXPECT_FALSE(findCycle(sampled([](double) { return 0.03; }), 0.001).lasts);
    EXPECT_FALSE(findCycle(sampled([](double t) { return 0.010 * std::sin(1.5 * t); }), 0.001).lasts);
    EXPECT_FALSE(findCycle(sampled([&](double t) { return hum(t) * std::exp(-3.0 * t); }), 0.001).lasts);
    EXPECT_FALSE(findCycle(sampled([&](double t) { return 0.1 * hum(t); }), 0.001).lasts);  // 10 um
    EXPECT_FALSE(findCycle({}, 0.001).lasts);
}

TEST(EnergyBalance, EarlierLossesDoNotHideEnergyGain) {
    EnergyBalance balance;
    balance.add(-1.0, 0.4, 0.0);  // friction dissipated 0.6 J of the hand's work
    EXPECT_EQ(balance.rise_j(), 0.0);
    balance.add(0.1, 0.0, 0.025);  // now the motor adds energy
    EXPECT_NEAR(balance.rise_j(), 0.075, 1e-12);
    balance.add(-0.2, 0.0, 0.0);
    balance.add(0.05, 0.0, 0.0);
    EXPECT_NEAR(balance.rise_j(), 0.075, 1e-12);
}

// Runs a case in which the user lets go of the device in soft tissue, at 1 kHz, without the controller.
// Stability condition of Colgate and Schenkel: b > K T/2.
CaseResult runReleasedCase(double damping_n_s_per_m) {
    static const Tissues tissues;
    StressCase c;
    c.device = haptics::findProfile("paper");
    c.tissues = Tissues::kLiver;
    c.hand = HandKind::none;
    c.resolution_m = 1e-6;
    c.mass_kg = 0.1;
    c.damping_n_s_per_m = damping_n_s_per_m;
    c.begin_s = 1.0;
    c.depth_m = 0.030;
    c.speed_m_s = 0.030;
    c.weight_share = 0.3;
    c.seed = 1;
    return runCase(c, tissues, false);
}

// HZ-FORCE-09
TEST(RunCase, FailsAboveTheStabilityBoundAndPassesBelow) {
    const CaseResult bad = runReleasedCase(0.01), good = runReleasedCase(5.0);
    EXPECT_GT(bad.bare_ratio, 1.0);
    EXPECT_TRUE(bad.fails());
    EXPECT_TRUE(bad.cycles()) << bad.cycle.amplitude_m;
    EXPECT_LT(good.bare_ratio, 1.0);
    EXPECT_FALSE(good.fails()) << good.rise_j << ' ' << good.cycle.amplitude_m << ' ' << good.step_n;
    EXPECT_GT(good.forced_share, 0.9);
    EXPECT_EQ(bad.ticks, 5000u);
}

TEST(Tally, MatchesHandCountedCases) {
    StressCase bare, held;
    bare.hand = HandKind::none;
    held.hand = HandKind::firm;
    CaseResult bad;
    bad.rise_j = 2.0;
    bad.rise_limit_j = 1.0;
    bad.cycle = {0.001, 30.0, true};
    bad.cycle_is_fed = true;
    bad.bare_ratio = 3.0;
    CaseResult ringing = bad;
    ringing.rise_j = 0.5;
    ringing.cycle_is_fed = false;
    const std::vector<JudgedCase> cases{{bare, bad}, {bare, ringing}, {held, CaseResult{}}};
    EXPECT_EQ(tally(cases).cases, 3);
    EXPECT_EQ(tally(cases).failed, 1);
    EXPECT_EQ(tally(cases).active_bare, 2);
    const Tally none = tally(cases, HandKind::none);
    EXPECT_EQ(none.cases, 2);
    EXPECT_EQ(none.energy, 1);
    EXPECT_EQ(none.cycles, 1);
    EXPECT_EQ(none.slowest_hz, 30.0);
    EXPECT_EQ(tally(cases, HandKind::firm).failed, 0);
}

}  // namespace
}  // namespace stylet::stress
