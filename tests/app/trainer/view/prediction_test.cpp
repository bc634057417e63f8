#include "app/trainer/view/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace stylet::trainer {
namespace {

using haptics::TickOutput;
using haptics::TipSample;
using haptics::Tool;

constexpr std::int64_t kMs_ns = 1'000'000;

// A motion with constant velocity and angular velocity.
Pose moving(double t_s) {
    return {glm::angleAxis(2.0 * t_s, Vec3(0.0, 1.0, 0.0)), Vec3(0.10 * t_s, -0.05 * t_s, 0.3)};
}

TipSample sampleAt(int tick, const Pose& pose, bool fresh = true, Tool tool = Tool::needle) {
    return {.t_ns = tick * kMs_ns,
            .tick = std::uint64_t(tick),
            .tool = tool,
            .fresh = fresh,
            .patient_from_tip = pose};
}

TickOutput tickAt(int tick, const Pose& pose, Tool tool = Tool::needle) {
    TickOutput out;
    out.tick = std::uint64_t(tick);
    out.tool = tool;
    (haptics::isNeedleTool(tool) ? out.patient_from_needle : out.patient_from_tool) = pose;
    return out;
}

// Feeds one tick of moving() per millisecond, from 1 to `last`.
void feed(TipPredictor& p, int last) {
    for (int i = 1; i <= last; ++i)
        p.add(sampleAt(i, moving(1e-3 * i)));
}

void expectPose(const Pose& a, const Pose& b, double m, double rad) {
    EXPECT_NEAR(glm::length(a.position_m - b.position_m), 0.0, m);
    EXPECT_NEAR(2.0 * std::acos(std::min(1.0, std::fabs(glm::dot(a.rotation, b.rotation)))), 0.0, rad);
}

TEST(Prediction, OfAConstantMotionIsExact) {
    for (const double window_s : {0.001, 0.004, 0.016, 0.064}) {
        TipPredictor p({.window_s = window_s});
        feed(p, 200);
        for (const int lead_ms : {0, 5, 11, 20, 50}) {
            const TickOutput drawn = p.at(tickAt(200, moving(0.200)), (200 + lead_ms) * kMs_ns);
            expectPose(drawn.patient_from_needle, moving(0.200 + 1e-3 * lead_ms), 1e-9, 1e-6);
        }
    }
}

TEST(Prediction, NoWindowOrSamplesMeansNoPrediction) {
    TipPredictor none({.window_s = 0.0}), empty;
    feed(none, 50);
    const TickOutput tick = tickAt(50, moving(0.050));
    EXPECT_EQ(none.at(tick, 70 * kMs_ns).patient_from_needle.position_m, tick.patient_from_needle.position_m);
    EXPECT_EQ(empty.at(tick, 70 * kMs_ns).patient_from_needle.position_m,
              tick.patient_from_needle.position_m);
}

// Prediction changes poses only. Events and forces stay those of the tick.
TEST(Prediction, PredictsOnlyPoses) {
    TipPredictor p;
    feed(p, 100);
    TickOutput tick = tickAt(100, moving(0.100));
    tick.phase = haptics::Phase::tenting;
    tick.force_n = 2.4;
    tick.depth_m = 0.010;
    tick.breath = {0.5, 0.8, 0.0};
    const TickOutput drawn = p.at(tick, 120 * kMs_ns);
    EXPECT_EQ(drawn.phase, haptics::Phase::tenting);
    EXPECT_EQ(drawn.force_n, 2.4);
    EXPECT_EQ(drawn.tick, 100u);
    EXPECT_NEAR(drawn.breath.v, 0.5 + 0.020 * 0.8, 1e-12);
    const Vec3 inward = -drawn.patient_from_needle.direction(Vec3(0.0, 0.0, 1.0));
    EXPECT_NEAR(
        drawn.depth_m,
        0.010 + glm::dot(drawn.patient_from_needle.position_m - tick.patient_from_needle.position_m, inward),
        1e-12);
    EXPECT_EQ(drawn.patient_from_tool.position_m, tick.patient_from_tool.position_m);
}

TEST(Prediction, PredictsOtherToolsAndAParkedProbe) {
    TipPredictor p;
    for (int i = 1; i <= 60; ++i) {
        TipSample s = sampleAt(i, moving(1e-3 * i), true, Tool::finger);
        s.parked = true;
        s.probe_m = {0.0, 0.0, 0.02e-3 * i};
        p.add(s);
    }
    TickOutput tick = tickAt(60, moving(0.060), Tool::finger);
    tick.probe_parked = true;
    tick.patient_from_probe.position_m = {0.0, 0.0, 1.2e-3};
    const TickOutput drawn = p.at(tick, 80 * kMs_ns);
    expectPose(drawn.patient_from_tool, moving(0.080), 1e-9, 1e-6);
    EXPECT_NEAR(drawn.patient_from_probe.position_m.z, 1.6e-3, 1e-9);
}

// HZ-TEACH-05
TEST(Prediction, LimitsTravelRotationAndLead) {
    const PredictionSettings settings;
    const auto fast = [](double t_s) {
        return Pose{glm::angleAxis(40.0 * t_s, Vec3(0.0, 0.0, 1.0)), Vec3(0.9 * t_s, 0.0, 0.0)};
    };
    TipPredictor p;
    for (int i = 1; i <= 60; ++i)
        p.add(sampleAt(i, fast(1e-3 * i)));
    const TickOutput tick = tickAt(60, fast(0.060));
    const TickOutput drawn = p.at(tick, 100 * kMs_ns);
    EXPECT_NEAR(drawn.patient_from_needle.position_m.x - 0.9 * 0.060, settings.max_travel_m, 1e-9);
    const Quat turn = drawn.patient_from_needle.rotation * glm::conjugate(tick.patient_from_needle.rotation);
    EXPECT_NEAR(2.0 * std::acos(turn.w), settings.max_turn_rad, 1e-9);
    // After the last sample, the prediction returns to the last position without a jump.
    const auto way = [&](int lead_ms) {
        return p.at(tick, (60 + lead_ms) * kMs_ns).patient_from_needle.position_m.x - 0.054;
    };
    EXPECT_LT(way(90), way(85));
    EXPECT_NEAR(way(90), 0.9 * 0.010, 1e-9);
    EXPECT_EQ(way(100), 0.0);
    EXPECT_EQ(way(5000), 0.0);
    EXPECT_EQ(way(-10), 0.0);  // this time has already been displayed
}

// HZ-TEACH-05
TEST(Prediction, StaleSamplesAreNotPredicted) {
    TipPredictor p;
    feed(p, 100);
    for (int i = 101; i <= 115; ++i)
        p.add(sampleAt(i, moving(0.100), false));
    EXPECT_GT(p.at(tickAt(115, moving(0.100)), 126 * kMs_ns).patient_from_needle.position_m.x, 0.0101);
    for (int i = 116; i <= 125; ++i)
        p.add(sampleAt(i, moving(0.100), false));
    const TickOutput tick = tickAt(125, moving(0.100));
    EXPECT_EQ(p.at(tick, 136 * kMs_ns).patient_from_needle.position_m, tick.patient_from_needle.position_m);
}

// A device with 200 samples per second, read at 1 kHz.
TEST(Prediction, SlowDeviceUsesItsOwnSampleRate) {
    TipPredictor p({.window_s = 0.004});
    for (int i = 0; i <= 100; ++i)
        p.add(sampleAt(i, moving(1e-3 * (i - i % 5)), i % 5 == 0));
    const TickOutput drawn = p.at(tickAt(100, moving(0.100)), 120 * kMs_ns);
    expectPose(drawn.patient_from_needle, moving(0.120), 1e-9, 1e-6);
}

TEST(Prediction, ToolChangeIsNotMotion) {
    TipPredictor p;
    feed(p, 100);
    p.add(sampleAt(101, {Quat(1.0, 0.0, 0.0, 0.0), Vec3(0.5)}, true, Tool::finger));
    const TickOutput tick = tickAt(101, {Quat(1.0, 0.0, 0.0, 0.0), Vec3(0.5)}, Tool::finger);
    EXPECT_EQ(p.at(tick, 121 * kMs_ns).patient_from_tool.position_m, Vec3(0.5));
    // The tick before the change is drawn without prediction.
    const TickOutput before = tickAt(100, moving(0.100));
    EXPECT_EQ(p.at(before, 121 * kMs_ns).patient_from_needle.position_m,
              before.patient_from_needle.position_m);
}

TEST(Prediction, PastCaptureIsUnchanged) {
    TipPredictor p;
    feed(p, 500);
    const TickOutput past = tickAt(100, moving(0.100)), unknown = tickAt(501, moving(0.501));
    EXPECT_EQ(p.at(past, 511 * kMs_ns).patient_from_needle.position_m, past.patient_from_needle.position_m);
    EXPECT_EQ(p.at(unknown, 511 * kMs_ns).patient_from_needle.position_m,
              unknown.patient_from_needle.position_m);
}

TEST(Offset, IsMeasuredAgainstWhereTheTipWasAtTheDisplayTime) {
    TipPredictor p;
    feed(p, 100);
    const TickOutput tick = tickAt(100, moving(0.100));
    p.drew(7, 120 * kMs_ns + kMs_ns / 2, tick);  // drawn without prediction, so 20.5 ms behind
    p.drew(8, 120 * kMs_ns + kMs_ns / 2, p.at(tick, 120 * kMs_ns + kMs_ns / 2));
    EXPECT_FALSE(p.measured());
    for (int i = 101; i <= 121; ++i)
        p.add(sampleAt(i, moving(1e-3 * i)));
    const auto late = p.measured(), ahead = p.measured();
    ASSERT_TRUE(late && ahead);
    EXPECT_FALSE(p.measured());
    EXPECT_EQ(late->frame, 7u);
    EXPECT_NEAR(late->lead_s, 0.0205, 1e-12);
    EXPECT_NEAR(late->distance_m, 0.0205 * std::sqrt(0.10 * 0.10 + 0.05 * 0.05), 1e-9);
    EXPECT_NEAR(late->angle_rad, 0.041, 1e-6);
    ASSERT_TRUE(late->ahead_s);
    EXPECT_NEAR(*late->ahead_s, -0.0205, 1e-9);
    EXPECT_EQ(ahead->frame, 8u);
    EXPECT_NEAR(ahead->distance_m, 0.0, 1e-9);
}

TEST(Offset, IsAbsentWithoutATruePose) {
    TipPredictor p;
    feed(p, 100);
    const TickOutput tick = tickAt(100, moving(0.100));
    p.drew(1, 110 * kMs_ns, tick);
    p.add(sampleAt(400, moving(0.400)));  // after a pause
    EXPECT_FALSE(p.measured());
    p.drew(2, 405 * kMs_ns, tickAt(400, moving(0.400)));
    p.add(sampleAt(406, moving(0.406), true, Tool::scalpel));
    EXPECT_FALSE(p.measured());
    // At rest there is a distance but no time difference.
    TipPredictor still;
    for (int i = 1; i <= 40; ++i)
        still.add(sampleAt(i, moving(0.0)));
    still.drew(3, 41 * kMs_ns, tickAt(40, moving(0.0)));
    still.add(sampleAt(42, moving(0.0)));
    const auto offset = still.measured();
    ASSERT_TRUE(offset);
    EXPECT_EQ(offset->distance_m, 0.0);
    EXPECT_FALSE(offset->ahead_s);
}

TEST(Offset, OldestPendingFrameIsDropped) {
    TipPredictor p;
    feed(p, 10);
    for (std::uint64_t i = 0; i < TipPredictor::kMaxPending + 3; ++i)
        p.drew(i, 20 * kMs_ns, tickAt(10, moving(0.010)));
    for (int i = 11; i <= 21; ++i)
        p.add(sampleAt(i, moving(1e-3 * i)));
    for (std::uint64_t i = 3; i < TipPredictor::kMaxPending + 3; ++i) {
        const auto offset = p.measured();
        ASSERT_TRUE(offset);
        EXPECT_EQ(offset->frame, i);
    }
    EXPECT_FALSE(p.measured());
}

}  // namespace
}  // namespace stylet::trainer
