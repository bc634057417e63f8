#include "haptics/devices/falcon/falcon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "patient/synth/random.h"
#include "tests/haptics/devices/falcon_world.h"

namespace stylet::haptics::falcon {
namespace {

using test::FalconWorld;
using test::kMs;
using testing::HasSubstr;

std::vector<std::uint8_t> makeFirmwareImage() {
    patient::synth::Random random(3, 0);
    std::vector<std::uint8_t> image(7914);
    for (std::uint8_t& byte : image)
        byte = std::uint8_t(random.bits());
    return image;
}

// Returns the force at the grip for given motor counts, computed only from virtual work and the closed-form
// inverse kinematics.
Vec3 forceOf(const std::array<int, 3>& motors, const Vec3& grip_m) {
    constexpr double h = 1e-6;
    Vec3 force(0.0);
    for (int j = 0; j < 3; ++j) {
        Vec3 d(0.0);
        d[j] = h;
        const Vec3 turn = (*anglesAt(grip_m + d) - *anglesAt(grip_m - d)) / (2.0 * h);
        for (int i = 0; i < 3; ++i)
            force[j] += -motors[std::size_t(i)] / 10'000.0 * turn[i];
    }
    return force;
}

std::array<int, 3> countsAt(const Vec3& grip_m) {
    const Angles angles = anglesAt(grip_m).value();
    std::array<int, 3> counts{};
    for (int i = 0; i < 3; ++i)
        counts[std::size_t(i)] = int(std::lround(countsFromRadians(angles[i])));
    return counts;
}

// HZ-FORCE-11
TEST(Falcon, BecomesReadyAfterHomingAndAppliesTheForce) {
    FalconWorld w;
    w.runFor(50 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
    EXPECT_THAT(w.why(), HasSubstr("pull its grip"));
    w.arm();
    w.runFor(50 * kMs);
    EXPECT_FALSE(w.armed());  // fault of the loop: device not ready
    EXPECT_EQ(w.pushed_ns, 0);

    const Vec3 grip{0.01, -0.02, 0.12};
    w.falcon.moveTo(countsAt(grip));
    w.falcon.press(kButtonCentre);
    w.falcon.home();
    w.runFor(50 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::ready);
    EXPECT_NEAR(glm::length(w.grip_m - grip), 0.0, 50e-6);  // about one encoder count
    EXPECT_EQ(w.buttons, std::uint32_t(kButtonCentre));
    EXPECT_EQ(w.pushed_ns, 0);
    w.force_n = {1.0, -2.0, 3.0};
    w.arm();
    w.runFor(50 * kMs);
    EXPECT_NEAR(glm::length(forceOf(w.falcon.motors(), grip) - w.force_n), 0.0, 0.02);
    EXPECT_EQ(w.falcon.leds(), kLedGreen);
    EXPECT_EQ(w.falcon.bad_packets, 0);
    EXPECT_LT(w.safety.silence_s, 0.003);
    EXPECT_EQ(w.fault(), "");
}

TEST(Falcon, ExchangesPacketsAtTheDeviceRate) {
    FalconWorld w;
    w.bringUp();
    const int before = w.falcon.packets;
    w.runFor(1000 * kMs);
    EXPECT_GE(w.falcon.packets - before, 950);
}

// HZ-FORCE-14
TEST(Falcon, EveryExitSendsZeroForce) {
    {
        FalconWorld w;
        w.bringUp();
        ASSERT_TRUE(w.falcon.hasMotorForce());
        w.device.stop();
        w.pass(kMs);
        EXPECT_FALSE(w.falcon.hasMotorForce());
        EXPECT_EQ(w.falcon.bad_packets, 0);
        EXPECT_FALSE(w.ready);
    }
    // The driver alone, in the middle of a run.
    FalconWorld w;
    w.runFor(50 * kMs);
    w.device.stop();
    FalconDriver* driver = new FalconDriver(std::make_unique<test::EmulatedBus>(w), w.clock(), {});
    std::string why;
    DeviceState state;
    ASSERT_EQ(driver->open(why), DeviceStage::opening);
    w.falcon.home();
    for (int i = 0; i < 50; ++i)
        driver->exchange({0.0, 0.0, 3.0}, state, why);
    ASSERT_TRUE(w.falcon.hasMotorForce());
    delete driver;
    EXPECT_FALSE(w.falcon.hasMotorForce());
}

// HZ-FORCE-06
TEST(Falcon, StalledLoopEndsInZeroForceWithin20Ms) {
    FalconWorld w;
    w.bringUp();
    ASSERT_TRUE(w.falcon.hasMotorForce());
    w.loop_stalled = true;
    const std::int64_t begin_ns = w.now_ns;
    w.runFor(100 * kMs);
    EXPECT_LE(w.pushed_ns - begin_ns, 20 * kMs);
    EXPECT_EQ(w.device.report().silences, 1u);
    EXPECT_EQ(w.fault(), "computer-late");  // it is reported, and not called unplugged
}

struct Injection {
    const char* name;
    std::function<void(FalconWorld&)> begin, end;
    const char* cause;  // as reported by the driver
};

// Lasting faults must end in zero force within 20 ms of the last good reply and name a cause. After the
// fault ends, the device must recover.
TEST(Falcon, PersistentFaultsEndInZeroForceAreReportedAndRecover) {
    const auto corrupt = [](int byte, int mask) {
        return [=](FalconWorld& w) {
            w.falcon.faults.xor_count = 1 << 30;
            w.falcon.faults.xor_byte = byte;
            w.falcon.faults.xor_mask = std::uint8_t(mask);
        };
    };
    const auto nothing = [](FalconWorld& w) { w.falcon.faults = {}; };
    const Injection injections[] = {
        {"silent", [](FalconWorld& w) { w.falcon.faults.silent = true; }, nothing, "stopped answering"},
        {"mute", [](FalconWorld& w) { w.falcon.faults.mute = true; }, nothing, "stopped answering"},
        {"drop", [](FalconWorld& w) { w.falcon.faults.drop = 1 << 30; }, nothing, "stopped answering"},
        {"cut", [](FalconWorld& w) { w.falcon.faults.cut = 1 << 30; }, nothing, "garbled"},
        {"first byte", corrupt(0, 0x02), nothing, "garbled"},
        {"letter", corrupt(5, 0x80), nothing, "garbled"},
        {"end", corrupt(15, 0x01), nothing, "garbled"},
        {"jump", [](FalconWorld& w) { w.falcon.moveTo({0, -516, -516}); },
         [](FalconWorld& w) { w.falcon.moveTo({-516, -516, -516}); }, "jumped"},
        {"impossible", [](FalconWorld& w) { w.falcon.moveTo({-516, -516, 32000}); },
         [](FalconWorld& w) { w.falcon.moveTo({-516, -516, -516}); }, "jumped"},
        {"unhomed", [](FalconWorld& w) { w.falcon.unhome(); }, [](FalconWorld& w) { w.falcon.home(); },
         "pull its grip"},
        {"power lost", [](FalconWorld& w) { w.falcon.powerCycle(); },
         [](FalconWorld& w) { w.falcon = test::FalconEmulator(true); }, "stopped answering"},
    };
    for (const Injection& injection : injections) {
        SCOPED_TRACE(injection.name);
        FalconWorld w;
        w.bringUp();
        ASSERT_TRUE(w.falcon.hasMotorForce());
        ASSERT_EQ(w.fault(), "");
        const std::int64_t begin_ns = w.now_ns;
        injection.begin(w);
        w.runFor(20 * kMs);
        EXPECT_LE(w.pushed_ns - begin_ns, 18 * kMs);
        EXPECT_FALSE(w.falcon.hasMotorForce());
        w.runFor(10 * kMs);
        EXPECT_NE(w.fault(), "");
        w.runFor(250 * kMs);
        EXPECT_THAT(w.why(), HasSubstr(injection.cause));
        EXPECT_LE(w.pushed_ns - begin_ns, 18 * kMs);

        injection.end(w);
        w.runFor(1500 * kMs);
        w.falcon.home();
        w.runFor(1500 * kMs);
        EXPECT_EQ(w.device.stage(), DeviceStage::ready);
        EXPECT_FALSE(w.falcon.hasMotorForce());  // only the user re-arms
        w.arm();
        w.runFor(50 * kMs);
        EXPECT_TRUE(w.falcon.hasMotorForce());
        EXPECT_EQ(w.fault(), "");
    }
}

// An unplugged device cannot be sent a zero force. The loop must still report the fault by name within 20
// ms.
// HZ-FORCE-07
TEST(Falcon, UnpluggingDuringAWriteIsReportedAndRecovers) {
    for (int bytes = 0; bytes <= 16; ++bytes) {
        SCOPED_TRACE(bytes);
        FalconWorld w;
        w.bringUp();
        w.falcon.faults.unplug_after_bytes = bytes;
        w.runFor(20 * kMs);
        EXPECT_FALSE(w.armed());
        EXPECT_THAT(w.fault(), HasSubstr("device-lost"));
        EXPECT_THAT(w.why(), HasSubstr("unplugged"));
        w.falcon = test::FalconEmulator(true);
        w.runFor(1000 * kMs);
        w.falcon.home();
        w.runFor(100 * kMs);
        EXPECT_EQ(w.device.stage(), DeviceStage::ready);
        EXPECT_TRUE(w.ready);
    }
}

TEST(Falcon, BlockedPipeEndsInZeroForceWhenItRecovers) {
    FalconWorld w;
    w.bringUp();
    w.falcon.faults.deaf = true;
    w.runFor(30 * kMs);
    EXPECT_EQ(w.fault(), "stale-input");
    w.falcon.faults.deaf = false;
    w.runFor(5 * kMs);
    EXPECT_FALSE(w.falcon.hasMotorForce());
}

// The device's thread does not run for a while, and the loop does. The Falcon itself has answered all the
// time: it is neither called silent nor given up. HZ-FORCE-07
TEST(Falcon, AStallOfItsThreadIsNotItsSilence) {
    for (const std::int64_t stall_ns : {30 * kMs, 400 * kMs}) {
        SCOPED_TRACE(stall_ns);
        FalconWorld w;
        w.bringUp();
        w.pass(stall_ns);
        EXPECT_FALSE(w.armed());
        EXPECT_EQ(w.fault(), "computer-late");
        w.runFor(50 * kMs);
        EXPECT_EQ(w.device.stage(), DeviceStage::ready);
        EXPECT_EQ(w.device.report().failures, 0u);
        EXPECT_EQ(w.fault(), "computer-late") << "and nothing else";
    }
}

// One lost or changed reply must cause nothing that a user could feel.
TEST(Falcon, SingleBadReplyIsTolerated) {
    const std::function<void(FalconWorld&)> blips[] = {
        [](FalconWorld& w) { w.falcon.faults.drop = 1; },
        [](FalconWorld& w) { w.falcon.faults.repeat = 1; },
        [](FalconWorld& w) { w.falcon.faults.cut = 1; },
        [](FalconWorld& w) { w.falcon.faults.late = 1; },
        [](FalconWorld& w) {
            w.falcon.faults.xor_count = 1;
            w.falcon.faults.xor_byte = 4;
            w.falcon.faults.xor_mask = 0x04;
        },
    };
    for (const auto& blip : blips) {
        FalconWorld w;
        w.bringUp();
        const Vec3 grip = w.grip_m;
        for (int i = 0; i < 20; ++i) {
            blip(w);
            w.runFor(20 * kMs);
            EXPECT_TRUE(w.armed()) << w.fault();
            EXPECT_EQ(w.grip_m, grip);
            EXPECT_TRUE(w.falcon.hasMotorForce());
        }
        EXPECT_EQ(w.device.report().failures, 0u);
    }
}

// After one late reply, the following replies must not stay one exchange behind.
TEST(Falcon, LateRepliesDoNotPileUp) {
    FalconWorld w;
    w.bringUp();
    w.falcon.faults.late = 1;
    w.runFor(20 * kMs);
    const Vec3 moved{0.0003, 0.0002, 0.1103};
    w.falcon.moveTo(countsAt(moved));
    w.runFor(3 * kMs);
    EXPECT_NEAR(glm::length(w.grip_m - moved), 0.0, 50e-6);
}

// HZ-FORCE-11
TEST(Falcon, AGarbledFlagDoesNotHomeIt) {
    FalconWorld w;
    w.runFor(50 * kMs);
    w.falcon.faults.xor_count = 5;
    w.falcon.faults.xor_byte = 13;
    w.falcon.faults.xor_mask = 0xF0;  // 'A' becomes 'A' + 0x70: all three bits
    w.runFor(50 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
    w.falcon.home();
    w.runFor(4 * kMs);  // all bits are set, but not yet for long enough
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
    EXPECT_FALSE(w.ready);
    w.runFor(30 * kMs);
    EXPECT_TRUE(w.ready);
}

// HZ-FORCE-15
TEST(Falcon, ClockJumpRecoversQuickly) {
    for (const std::int64_t jump_ns : {3'600'000 * kMs, -3'600'000 * kMs, 50 * kMs, -50 * kMs}) {
        SCOPED_TRACE(jump_ns);
        FalconWorld w;
        w.bringUp();
        w.clock_error_ns += jump_ns;
        w.runFor(30 * kMs);
        EXPECT_TRUE(w.armed()) << w.fault() << w.why();
        EXPECT_TRUE(w.falcon.hasMotorForce());
        EXPECT_EQ(w.device.report().failures, 0u);
    }
}

// Faster than the safety limit, which the driver does not enforce: 40 mm back and forth, twelve times per
// second, up to 1.5 m/s and 11 g.
TEST(Falcon, FastHandMotionIsNotADriverFault) {
    FalconWorld w;
    w.falcon.moveTo(countsAt({0.0, 0.0, 0.12}));
    w.bringUp();
    double worst_m = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const double x_m = 0.02 * std::sin(0.075 * i);
        const Vec3 grip(x_m, 0.3 * x_m, 0.12);
        w.falcon.moveTo(countsAt(grip));
        w.runFor(kMs);
        worst_m = std::max(worst_m, glm::length(w.grip_m - grip));
        ASSERT_EQ(w.safety.faults & ~std::uint32_t(kFaultOverSpeed), 0u) << w.fault() << i;
    }
    EXPECT_EQ(w.fault(), "over-speed");
    EXPECT_LT(worst_m, 0.004);  // the reply is one or two exchanges old
    EXPECT_EQ(w.device.report().failures, 0u);
}

#ifdef STYLET_LONG_TESTS
constexpr int kInjections = 1'000'000;
#else
constexpr int kInjections = 4'000;
#endif

// Faults of every kind, at any time, for any duration. No wrong pose is ever reported. After 20 ms of a
// lasting fault the force is zero and the loop names the fault. After the fault the device recovers.
// HZ-FORCE-21
TEST(Falcon, RandomFaultsEndInZeroForceAndRecover) {
    patient::synth::Random random(5, 0);
    const Vec3 grip{0.005, -0.01, 0.115};
    FalconWorld w;
    w.falcon.moveTo(countsAt(grip));
    w.bringUp();
    auto& faults = w.falcon.faults;
    const std::function<void(int count)> begin[] = {
        [&](int) { faults.silent = true; },
        [&](int) { faults.mute = true; },
        [&](int count) { faults.drop = count; },
        [&](int count) { faults.repeat = count; },
        [&](int count) { faults.cut = count; },
        [&](int count) { faults.late = count; },
        [&](int) { faults.deaf = true; },
        [&](int count) {
            faults.xor_count = count;
            faults.xor_byte = int(random.uniform(0.0, 16.0));
            faults.xor_mask = std::uint8_t(1 + random.uniform(0.0, 255.0));
        },
        [&](int count) { faults.unplug_after_bytes = count; },
        [&](int) { w.clock_error_ns = std::int64_t(random.uniform(-1e12, 1e12)); },
        [&](int) { w.falcon.unhome(); },
    };
    std::array<int, 11> stood{};
    for (int i = 0; i < kInjections; ++i) {
        const int kind = int(random.uniform(0.0, 11.0));
        const auto length_ns = std::int64_t(random.uniform(0.0, 60.0) * 1e6);
        const int count = 1 + int(random.uniform(0.0, 60.0));
        begin[kind](count);
        const std::int64_t begin_ns = w.now_ns;
        w.runFor(length_ns);
        // Faults counted in replies last at least as many milliseconds. A garbled byte may be one that no
        // reply uses.
        const bool counted = kind == 2 || kind == 4;
        const std::int64_t stood_ns = counted ? std::min<std::int64_t>(length_ns, count * kMs) : length_ns;
        if ((kind == 0 || kind == 1 || kind == 10 || counted) && stood_ns > 20 * kMs) {
            ++stood[std::size_t(kind)];
            // After the force has ended, the device pushes again only after re-arming.
            ASSERT_LE(w.pushed_ns - begin_ns, 19 * kMs) << "kind " << kind << " of " << i;
            ASSERT_TRUE(stood_ns < 26 * kMs || w.fault() != "") << "kind " << kind << " of " << i;
        }
        // The largest error that can pass is a quarter of the range of the count's second letter.
        ASSERT_LT(glm::length(w.grip_m - grip), 0.0016) << "kind " << kind << " of " << i;
        faults = {};
        w.runFor(25 * kMs);  // time to notice remaining faults
        for (int turn = 0; turn < 400 && w.device.stage() != DeviceStage::ready; ++turn) {
            w.falcon.home();
            w.runFor(25 * kMs);
        }
        w.runFor(30 * kMs);
        w.arm();
        w.runFor(std::int64_t(random.uniform(15.0, 30.0) * 1e6));
        ASSERT_EQ(w.fault(), "") << "kind " << kind << " of " << i << ": " << w.why();
        ASSERT_TRUE(w.falcon.hasMotorForce());
        ASSERT_LT(glm::length(w.grip_m - grip), 50e-6) << "kind " << kind << " of " << i;
    }
    for (const std::size_t kind : {0u, 1u, 2u, 4u, 10u})
        EXPECT_GT(stood[kind], kInjections / 50) << kind;
}

TEST(Falcon, FirmwareIsLoadedIfMissing) {
    FalconWorld w(false, {.firmware = {makeFirmwareImage(), ""}});
    while (w.device.stage() != DeviceStage::needsFirmware && w.now_ns < 5000 * kMs)
        w.runFor(10 * kMs);
    w.runFor(10 * kMs);
    EXPECT_EQ(w.why(), "loading the Falcon's firmware");
    w.runFor(5000 * kMs);
    EXPECT_TRUE(w.falcon.hasFirmware());
    EXPECT_EQ(w.falcon.image(), makeFirmwareImage());
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
    EXPECT_EQ(w.device.report().failures, 0u);
    w.falcon.home();
    w.runFor(100 * kMs);
    EXPECT_TRUE(w.ready);
    EXPECT_EQ(w.pushed_ns, 0);
}

TEST(Falcon, FirmwareLoadingRetriesCommonFailures) {
    const std::function<void(FalconWorld&)> failures[] = {
        [](FalconWorld& w) { w.falcon.faults.wrong_echoes = 1; },
        [](FalconWorld& w) { w.falcon.faults.no_echoes = 1; },
        [](FalconWorld& w) { w.falcon.faults.never_greets = true; },
    };
    for (const auto& fail : failures) {
        FalconWorld w(false, {.firmware = {makeFirmwareImage(), ""}});
        fail(w);
        w.runFor(3000 * kMs);
        w.falcon.faults = {};
        w.runFor(20'000 * kMs);
        EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming) << w.why();
    }
}

TEST(Falcon, PersistentLoadingFailureIsReported) {
    FalconWorld w(false, {.firmware = {makeFirmwareImage(), ""}});
    w.falcon.image_bytes = 9999;  // accepts the image but does not run it
    w.runFor(120'000 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsFirmware);
    EXPECT_THAT(w.why(), HasSubstr("power supply"));
    // Unplug and plug in again: the driver tries again.
    w.plugged = false;
    w.falcon.faults.unplugged = true;
    w.runFor(1000 * kMs);
    w.plugged = true;
    w.falcon = test::FalconEmulator(false);
    w.runFor(20'000 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
}

TEST(Falcon, MissingFirmwareFileIsReported) {
    FalconWorld w(false);
    w.runFor(2000 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsFirmware);
    EXPECT_THAT(w.why(), HasSubstr("pass the vendor's file"));
    w.falcon = test::FalconEmulator(true);  // another program loaded the firmware
    w.falcon.control(3, 2);
    w.runFor(200 * kMs);
    EXPECT_EQ(w.device.stage(), DeviceStage::needsHoming);
}

TEST(FalconMotors, AreScaledTogetherAndKeepTheDirection) {
    patient::synth::Random random(11, 0);
    int limited = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 grip{random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04), random.uniform(0.08, 0.16)};
        const Vec3 force = random.jitter3(30.0);
        const auto motors = computeMotorCounts(force, grip, {});
        const std::array<int, 3> counts{motors[0], motors[1], motors[2]};
        int most = 0;
        for (const int count : counts)
            most = std::max(most, std::abs(count));
        EXPECT_LE(most, 4095);
        limited += most >= 4094;
        const Vec3 made = forceOf(counts, grip);
        const double length = glm::length(force);
        EXPECT_LE(glm::length(made), 8.02);
        // Rounding to counts turns the force by far less than a degree, except for the smallest forces.
        if (length > 1.0) {
            EXPECT_GT(glm::dot(made, force) / glm::length(made) / length, 0.9999);
        }
    }
    EXPECT_GT(limited, 20);
}

TEST(FalconMotors, FollowTheCalibration) {
    const Calibration twice{.measured_per_asked = {2.0, 1.0, 0.5}, .measured = true, .how = ""};
    const auto counts = [](const std::array<std::int16_t, 3>& m) {
        return std::array<int, 3>{m[0], m[1], m[2]};
    };
    const Vec3 made = forceOf(counts(computeMotorCounts({2.0, 2.0, 2.0}, kCentre_m, twice)), kCentre_m);
    EXPECT_NEAR(made.x, 1.0, 0.01);
    EXPECT_NEAR(made.y, 2.0, 0.01);
    EXPECT_NEAR(made.z, 4.0, 0.01);
    EXPECT_TRUE(makeProfile(twice).force_calibrated);
    EXPECT_FALSE(makeProfile({}).force_calibrated);
    EXPECT_EQ(makeProfile({}).force_peak_n, 8.0);
}

TEST(FalconMotors, AreZeroForInvalidInput) {
    const std::array<std::int16_t, 3> zero{};
    const double inf = std::numeric_limits<double>::infinity();
    EXPECT_EQ(computeMotorCounts({std::nan(""), 0.0, 0.0}, kCentre_m, {}), zero);
    EXPECT_EQ(computeMotorCounts({0.0, inf, 0.0}, kCentre_m, {}), zero);
    EXPECT_EQ(computeMotorCounts({0.0, 0.0, 1.0}, {0.0, 0.0, 0.5}, {}), zero);
    EXPECT_EQ(computeMotorCounts({0.0, 0.0, 1.0}, {std::nan(""), 0.0, 0.1}, {}), zero);
    EXPECT_EQ(computeMotorCounts(Vec3(0.0), kCentre_m, {}), zero);
}

}  // namespace
}  // namespace stylet::haptics::falcon
