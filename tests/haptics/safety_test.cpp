#include "haptics/output/safety.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "tests/support/constants.h"

namespace stylet::haptics {
namespace {

using test::kNaN;

// A device that can misbehave. Measures the time until its force is zero.
struct SafetyBench {
    explicit SafetyBench(double dt = 0.001) : dt_s(dt) {}

    void tick() {
        const std::uint32_t fault_bits = checkDevice(safety, profile, device, dt_s);
        stepSafety(safety, fault_bits, force_n, wall_n, dt_s);
    }
    void run(double seconds) {
        for (int i = 0; i < std::lround(seconds / dt_s); ++i)
            tick();
    }
    double zeroAfter_s() {
        int ticks = 0;
        while (safety.level > 0.0 && ticks < 1000000)
            tick(), ++ticks;
        return ticks * dt_s;
    }

    double dt_s;
    SafetyState safety;
    DeviceProfile profile;
    DeviceState device;
    double force_n = 0.0, wall_n = 0.0;
};

TEST(Safety, EveryBitHasANameAndAText) {
    std::set<std::string> names;
    std::uint32_t bits = 0;
    for (const FaultText& t : faultTexts()) {
        EXPECT_EQ(bits & t.bit, 0u);
        EXPECT_GT(std::uint32_t(t.bit), bits) << "lowest first";
        bits |= t.bit;
        EXPECT_TRUE(names.insert(t.name).second);
        EXPECT_GT(std::strlen(t.text), 10u);
    }
    EXPECT_EQ(bits, 2u * kFaultHostLate - 1u);
}

// HZ-FORCE-02
TEST(Safety, ForceRisesOverItsTimeAtEveryRate) {
    for (const double rate_hz : {1000.0, 2000.0, 4000.0}) {
        SafetyBench w(1.0 / rate_hz);
        w.run(kSettle_s - w.dt_s);
        EXPECT_EQ(w.safety.stage, ForceStage::waiting);
        w.run(w.dt_s);
        EXPECT_EQ(w.safety.stage, ForceStage::rising);
        EXPECT_EQ(w.safety.level, 0.0);
        w.run(0.5 * kStartRamp_s);
        EXPECT_NEAR(w.safety.level, 0.5, 1e-9);
        w.run(0.5 * kStartRamp_s + w.dt_s);
        EXPECT_EQ(w.safety.stage, ForceStage::on);
        EXPECT_EQ(w.safety.level, 1.0);
    }
}

// HZ-FORCE-02
TEST(Safety, ForceDoesNotStartInContact) {
    for (const double force_n : {1.01 * kSmallForce_n, 20.0, kNaN}) {
        SafetyBench w;
        w.force_n = force_n;
        w.run(5.0);
        EXPECT_EQ(w.safety.stage, ForceStage::waiting);
        EXPECT_EQ(w.safety.awaited, kWaitsForSmallForce);
        EXPECT_EQ(w.safety.faults, 0u);
        w.force_n = kSmallForce_n;
        w.run(kSettle_s + kStartRamp_s + 0.002);
        EXPECT_EQ(w.safety.stage, ForceStage::on);
        w.force_n = force_n;  // large forces are allowed once the ramp has started
        w.run(1.0);
        EXPECT_EQ(w.safety.level, 1.0);
    }
}

TEST(Safety, WallForceIsDistinguishedFromContact) {
    SafetyBench w;
    w.force_n = 0.5;
    w.wall_n = 0.3;
    w.run(1.0);
    EXPECT_EQ(w.safety.awaited, kWaitsOffWall);
    w.wall_n = 0.1;
    w.run(1.0);
    EXPECT_EQ(w.safety.awaited, kWaitsForSmallForce);
}

TEST(Safety, MissingDeviceIsAwaitedWithoutAFault) {
    SafetyBench w;
    w.device = {};
    w.device.flags = 0;
    w.device.fresh = 0;
    w.device.device_from_stylus.position_m.x = kNaN;
    w.run(10.0);
    EXPECT_EQ(w.safety.stage, ForceStage::waiting);
    EXPECT_EQ(w.safety.faults, 0u);
    EXPECT_EQ(w.safety.awaited, kFaultDeviceLost | kFaultHandOff | kFaultBadPose | kFaultStaleInput);
    w.device = {};
    w.run(kSettle_s + kStartRamp_s + 0.002);
    EXPECT_EQ(w.safety.stage, ForceStage::on);
}

struct Cause {
    const char* name;
    Fault fault;
    void (*make)(SafetyBench&);
};
const Cause kCauses[] = {
    {"clutch says nonsense", kFaultBadPose,
     [](SafetyBench& w) {
         w.device.flags |= kDeviceClutch;
         w.device.force_share = 1.5;
     }},
    {"clutched grip nowhere", kFaultBadPose,
     [](SafetyBench& w) {
         w.device.flags |= kDeviceClutch;
         w.device.grip_at_m.y = kNaN;
     }},
    {"unplugged", kFaultDeviceLost, [](SafetyBench& w) { w.device.flags &= ~std::uint32_t(kDeviceReady); }},
    {"released by a late computer", kFaultHostLate,
     [](SafetyBench& w) { w.device.flags = kDeviceHandOn | kDeviceHostLate; }},
    {"not polled in time", kFaultHostLate,
     [](SafetyBench& w) {
         w.device.fresh = 0;
         w.device.flags |= kDeviceHostLate;
     }},
    {"let go", kFaultHandOff, [](SafetyBench& w) { w.device.flags &= ~std::uint32_t(kDeviceHandOn); }},
    {"headset off", kFaultNotFocused, [](SafetyBench& w) { w.safety.focused = false; }},
    {"NaN", kFaultBadPose, [](SafetyBench& w) { w.device.device_from_stylus.position_m.y = kNaN; }},
    {"no rotation", kFaultBadPose, [](SafetyBench& w) { w.device.device_from_stylus.rotation.w = 0.5; }},
    {"far away", kFaultBadPose, [](SafetyBench& w) { w.device.device_from_stylus.position_m.y = 10.5; }},
    {"leap", kFaultOverSpeed, [](SafetyBench& w) { w.device.device_from_stylus.position_m.z += 0.02; }},
    {"clutched grip flung", kFaultOverSpeed,
     [](SafetyBench& w) {
         w.device.flags |= kDeviceClutch;
         w.device.grip_at_m.z += 0.02;
     }},
    {"out of reach", kFaultOutOfReach,
     [](SafetyBench& w) {
         w.profile.workspace_radius_m = 0.05;
         w.device.device_from_stylus.position_m = {0.0, 0.0, 0.0751};
     }},
    {"silence", kFaultStaleInput, [](SafetyBench& w) { w.device.fresh = 0; }},
};

class SafetyCause : public testing::TestWithParam<Cause> {};
INSTANTIATE_TEST_SUITE_P(All, SafetyCause, testing::ValuesIn(kCauses),
                         [](const auto& cause) { return "Cause" + std::to_string(cause.index); });

// HZ-FORCE-07
TEST_P(SafetyCause, EndsInZeroWithinTwentyMillisecondsAndStaysThere) {
    for (const double dt_s : {0.001, 0.0005, 0.00025}) {
        SafetyBench w(dt_s);
        w.run(2.0);
        ASSERT_EQ(w.safety.level, 1.0);
        const DeviceState good = w.device;
        const DeviceProfile wide = w.profile;
        GetParam().make(w);
        EXPECT_LE(w.zeroAfter_s(), 0.020 + 1e-9) << GetParam().name;
        w.run(0.010);
        EXPECT_EQ(w.safety.stage, ForceStage::off);
        EXPECT_NE(w.safety.faults & GetParam().fault, 0u) << GetParam().name;

        w.run(1.0);
        rearm(w.safety);  // the cause persists, so nothing starts
        w.run(1.0);
        if (GetParam().fault != kFaultOverSpeed) {  // a single jump, at rest since then
            EXPECT_EQ(w.safety.level, 0.0);
            EXPECT_NE(w.safety.awaited & GetParam().fault, 0u) << GetParam().name;
            w.device = good;
        }
        w.profile = wide;
        w.safety.focused = true;
        w.run(2.0);
        EXPECT_EQ(w.safety.stage, ForceStage::on) << GetParam().name;
        EXPECT_EQ(w.safety.faults, 0u);
    }
}

// HZ-FORCE-08
TEST(Safety, OnlyAnExplicitRearmRestoresTheForce) {
    SafetyBench w;
    w.run(2.0);
    w.device.flags = 0;
    w.tick();
    w.device = {};
    rearm(w.safety);  // ignored: the force is still falling
    w.run(5.0);
    EXPECT_EQ(w.safety.stage, ForceStage::off);
    EXPECT_EQ(w.safety.level, 0.0);
    EXPECT_EQ(w.safety.faults, kFaultDeviceLost | kFaultHandOff);
    rearm(w.safety);
    w.run(0.010);
    EXPECT_EQ(w.safety.faults, 0u);
    EXPECT_EQ(w.safety.level, 0.0);
    w.run(0.1);
    EXPECT_GT(w.safety.level, 0.05);
    EXPECT_LT(w.safety.level, 0.07);  // a ramp, not a jump
    rearm(w.safety);                  // nothing to re-arm
    EXPECT_EQ(w.safety.stage, ForceStage::rising);
}

// HZ-FORCE-20
TEST(Safety, FastHandLosesTheForceUntilItIsSlow) {
    SafetyBench w;
    w.run(2.0);
    const auto move = [&](double speed_m_s, double seconds) {
        for (int i = 0; i < std::lround(seconds / w.dt_s); ++i) {
            w.device.device_from_stylus.position_m.x += speed_m_s * w.dt_s;
            w.tick();
        }
    };
    move(0.95, 0.2);
    EXPECT_EQ(w.safety.faults, 0u);
    move(1.05, 0.05);
    EXPECT_EQ(w.safety.faults, kFaultOverSpeed);
    rearm(w.safety);
    move(0.5, 0.5);  // slower than the cut-off speed, but not yet slow enough
    EXPECT_EQ(w.safety.awaited, kFaultOverSpeed);
    move(0.25, 0.5);
    EXPECT_EQ(w.safety.stage, ForceStage::rising);
}

TEST(Safety, ShortSilenceDipsTheForceWithoutAFault) {
    SafetyBench w;
    w.run(2.0);
    w.device.fresh = 0;
    w.run(0.008);
    EXPECT_EQ(w.safety.level, 1.0);
    w.run(0.004);
    EXPECT_NEAR(w.safety.level, 0.6, 1e-9);
    w.device.fresh = 1;
    w.device.device_from_stylus.position_m.x += 0.2 * 0.013;  // where the hand is by now, at 0.2 m/s
    w.tick();
    EXPECT_EQ(w.safety.faults, 0u);
    EXPECT_NEAR(w.safety.speed_m_s, 0.2, 1e-9);
    EXPECT_EQ(w.safety.stage, ForceStage::rising);
    w.run(0.4 * kStartRamp_s + 0.002);
    EXPECT_EQ(w.safety.stage, ForceStage::on);
}

// HZ-FORCE-19
TEST(Safety, TheWallIsSoftContinuousAndConservative) {
    DeviceProfile profile;
    profile.workspace_centre_m = {0.01, 0.0, 0.0};
    profile.workspace_radius_m = 0.08;
    EXPECT_EQ(workspaceWall(profile, {0.01, 0.0719, 0.0}).force_n, Vec3(0.0));
    EXPECT_NEAR(workspaceWall(profile, {0.01, 0.074, 0.0}).force_n.y, -0.4, 1e-12);
    EXPECT_NEAR(workspaceWall(profile, {0.01, -0.2, 0.0}).force_n.y, 1.0, 1e-12);
    profile.stiffness_n_per_m = 400.0;  // a softer device gets a softer wall
    EXPECT_NEAR(workspaceWall(profile, {0.01, 0.074, 0.0}).force_n.y, -0.2, 1e-12);
    for (double y = 0.0705; y < 0.1; y += 0.0001) {
        const double slope = (workspaceWall(profile, {0.01, y + 1e-7, 0.0}).energy_j -
                              workspaceWall(profile, {0.01, y - 1e-7, 0.0}).energy_j) /
                             2e-7;
        EXPECT_NEAR(slope, -workspaceWall(profile, {0.01, y, 0.0}).force_n.y, 2e-4);
    }
    EXPECT_EQ(workspaceWall({}, {5.0, 0.0, 0.0}).force_n, Vec3(0.0));  // workspace unknown
}

}  // namespace
}  // namespace stylet::haptics
