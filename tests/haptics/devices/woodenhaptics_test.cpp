// Tests the driver with an emulated board.
#include "haptics/devices/woodenhaptics/woodenhaptics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <thread>

#include "haptics/devices/polled.h"
#include "tests/haptics/devices/wooden_json.h"
#include "tests/support/constants.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/wait_until.h"
#include "tests/support/woodenhaptics_emulator.h"

namespace stylet::haptics {
namespace {

using test::HidNode;
using test::kMs;
using test::WoodenHapticsEmulator;
using BoardFault = WoodenHapticsEmulator::Fault;

const Vec3 kPush_n{0.3, 0.2, -0.4};

// Number of commands, 5 ms each, that may still carry force after a fault: four, and one that answers a
// report from before it.
constexpr std::uint64_t kCommandsUntilZero = 5;

// Reports to read until one is newer than the test's last change: one may be queued, one may be in transit.
constexpr int kNewestAfter = 3;

class WoodenHapticsDriver : public testing::Test {
  protected:
    void SetUp() override {
        if (!test::underUmockdev()) GTEST_SKIP() << "not run under umockdev";
    }
    static WoodenModel model(const std::string& gravity = "0") {
        return parseWoodenModel(test::woodenJson("g_constant", gravity), "arm.json");
    }
    static WoodenModel modelWithWrist() {
        WoodenModel m = model();
        m.counts_per_turn = {2000, 2000, 2000, 1024, 1024, 1024};
        return m;
    }

    WoodenHapticsEmulator& plugIn() {
        board_.reset();
        return board_.emplace();
    }
    // Waits until the board has processed the command and answered. The driver waits only 5 ms for a
    // report, so a stall of the test machine could otherwise lose one.
    template <typename Call>
    auto settled(const Call& call) {
        const std::uint64_t before = board_ ? board_->received() : 0;
        const auto result = call();
        const auto answered = [&] {
            return stage_ == DeviceStage::failed || stage_ == DeviceStage::absent ||
                   !board_->isResponsive() || board_->received() > before ||
                   (board_->sending() && board_->waiting());
        };
        if (board_) {
            EXPECT_TRUE(test::waitUntil(answered));
        }
        return result;
    }
    DeviceStage exchangeAtOnce(Driver& driver, const Vec3& force_n) {
        state_.fresh = 0;
        why_.clear();
        return settled([&] { return stage_ = driver.exchange(force_n, state_, why_); });
    }
    DeviceStage exchange(Driver& driver, const Vec3& force_n = Vec3{0.0}) {
        return exchangeAtOnce(driver, stage_ == DeviceStage::ready ? force_n : Vec3{0.0});
    }
    // Exchanges until `wanted` is reached. Returns the number of exchanges, or -1.
    int until(Driver& driver, DeviceStage wanted, int most, const Vec3& force_n = Vec3{0.0}) {
        for (int i = 1; i <= most; ++i)
            if (exchange(driver, force_n) == wanted) return i;
        return -1;
    }
    // Exchanges until `reports` fresh reports have arrived.
    void hear(Driver& driver, int reports, const Vec3& force_n = Vec3{0.0}) {
        for (int i = 0; i < 400 && reports > 0; ++i) {
            ASSERT_EQ(exchange(driver, force_n), DeviceStage::ready) << why_;
            reports -= int(state_.fresh);
        }
        ASSERT_EQ(reports, 0);
    }
    // Opens the driver and waits until the board reports that its button is not pressed.
    void openAndWait(Driver& driver) {
        ASSERT_EQ(driver.open(why_), DeviceStage::opening) << why_;
        for (int heard = 0, i = 0; heard < 5 && i < 400; ++i) {
            ASSERT_EQ(exchange(driver), DeviceStage::needsHoming) << why_;
            heard += why_.find("press the button") != std::string::npos;
        }
    }
    void makeReady(Driver& driver, WoodenHapticsEmulator& board) {
        openAndWait(driver);
        board.pressButton();
        ASSERT_GT(until(driver, DeviceStage::ready, 400), 0) << why_;
    }

    WoodenHapticsEmulator& plugInReady(Driver& driver) {
        plugIn();
        makeReady(driver, *board_);
        return *board_;
    }

    test::SteppedClock time_;
    std::optional<WoodenHapticsEmulator> board_;
    DeviceState state_;
    std::string why_;
    DeviceStage stage_ = DeviceStage::absent;
};

TEST_F(WoodenHapticsDriver, IsAbsentWithoutABoard) {
    const HidNode another({0x1234, 0x0007, "mbed.org", "HID DEVICE", {0x05, 0x01}});
    WoodenHaptics driver(time_.clock(), model());
    EXPECT_EQ(driver.open(why_), DeviceStage::absent);
    EXPECT_NE(why_.find("1234:0006"), std::string::npos) << why_;
    driver.close();
}

// HZ-FORCE-11
TEST_F(WoodenHapticsDriver, GivesNoCurrentBeforeItIsHomed) {
    WoodenHapticsEmulator& board = plugIn();
    board.moveTo({123, -456, 789});
    WoodenHaptics driver(time_.clock(), model("9.81"));
    ASSERT_EQ(driver.open(why_), DeviceStage::opening);
    for (int i = 0; i < 50; ++i)
        ASSERT_EQ(exchangeAtOnce(driver, kPush_n), DeviceStage::needsHoming);
    EXPECT_EQ(board.commandLog().powered, 0u);
    EXPECT_GT(board.commandLog().commands, 10u);
}

TEST_F(WoodenHapticsDriver, TheButtonHomesItToTheModelsCounts) {
    WoodenHapticsEmulator& board = plugIn();
    board.moveTo({123, -456, 789});
    WoodenHaptics driver(time_.clock(), model());
    makeReady(driver, board);
    hear(driver, 1);
    EXPECT_GE(board.commandLog().calibrations, 1u);
    EXPECT_FALSE(board.commandLog().malformed);

    // The counts of the calibration: 0, -10, 6000.
    const Vec3 t{0.0, 10.0 / 2000 * 2 * std::numbers::pi * 0.011 / 0.120,
                 3.0 * 2 * std::numbers::pi * 0.012 / 0.125};
    const double out = 0.205 * std::sin(t.y) + 0.245 * std::sin(t.z) - 0.220;
    const double up = 0.205 * std::cos(t.y) - 0.245 * std::cos(t.z);
    EXPECT_NEAR(state_.device_from_stylus.position_m.x, 0.0, 1e-12);
    EXPECT_NEAR(state_.device_from_stylus.position_m.y, up, 1e-12) << "up is the device's +y";
    EXPECT_NEAR(state_.device_from_stylus.position_m.z, out, 1e-12) << "out is the device's +z";
}

// The board reports a button press until it is calibrated. A press from before the program started must not
// home the device.
TEST_F(WoodenHapticsDriver, AnOldPressOfTheButtonDoesNotHome) {
    WoodenHapticsEmulator& board = plugIn();
    board.moveTo({123, -456, 789});
    board.pressButton();
    WoodenHaptics driver(time_.clock(), model());
    openAndWait(driver);
    for (int i = 0; i < 30; ++i)
        ASSERT_EQ(exchange(driver), DeviceStage::needsHoming) << why_;
    board.pressButton();
    EXPECT_GT(until(driver, DeviceStage::ready, 400), 0);
    EXPECT_EQ(board.commandLog().powered, 0u);
}

TEST_F(WoodenHapticsDriver, ForcesBecomeTheMotorsCurrents) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 2, kPush_n);
    const std::array<int, 3> ma = board.commandLog().motor_ma;
    // Base frame to device frame: x (out) is the device's z, y is the device's x, z (up) is the device's y.
    const Vec3 t = armAngles_rad(model(), {0, -10, 6000, 0, 0, 0});
    const Vec3 torque = glm::transpose(armJacobian(model(), t)) * Vec3{-0.4, 0.3, 0.2};
    EXPECT_NEAR(ma[0], 1000.0 * torque.x * 0.010 / 0.160 / 0.0259, 1.0);
    EXPECT_NEAR(ma[1], -1000.0 * torque.y * 0.011 / 0.120 / 0.026, 1.0);
    EXPECT_NEAR(ma[2], 1000.0 * torque.z * 0.012 / 0.125 / 0.027, 1.0);
    EXPECT_NE(ma[0], 0);
}

// HZ-FORCE-01
TEST_F(WoodenHapticsDriver, CurrentsStayWithinTwoAmperesWhateverTheForce) {
    WoodenHaptics driver(time_.clock(), model("9.81"));
    WoodenHapticsEmulator& board = plugInReady(driver);
    for (const double n : {1e3, -1e9, 1e300, double(NAN), double(INFINITY)})
        hear(driver, 2, Vec3{n, -n, n});
    EXPECT_EQ(board.commandLog().largest_ma, 2000);
}

// HZ-FORCE-03
TEST_F(WoodenHapticsDriver, NonFiniteForceIsNotSent) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 10, Vec3{0.1, NAN, INFINITY});
    EXPECT_EQ(board.commandLog().powered, 0u);
}

TEST_F(WoodenHapticsDriver, SixteenBitCountsAreUnwrapped) {
    WoodenModel m = model();
    m.calibration_counts = {32000, 0, 0, 0, 0, 0};
    WoodenHaptics driver(time_.clock(), m);
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1);
    for (const int counts : {32400, 32760, 33100, 33500}) {
        board.moveTo({std::int16_t(std::uint16_t(counts)), 0, 0});
        hear(driver, kNewestAfter);
    }
    const double a = 33500 * 2 * std::numbers::pi / 2000 * 0.010 / 0.160;
    EXPECT_NEAR(state_.device_from_stylus.position_m.z, -0.220, 1e-12);
    EXPECT_NEAR(armAngles_rad(m, {33500, 0, 0, 0, 0, 0}).x, a, 1e-12);
    // With both arms along the vertical axis the reach is zero. Lift the forearm to make the turn visible.
    for (int c = 0; c <= 4000; c += 400) {
        board.moveTo({std::int16_t(std::uint16_t(33500)), 0, std::int16_t(c)});
        hear(driver, kNewestAfter);
    }
    const double reach = 0.245 * std::sin(2.0 * 2 * std::numbers::pi * 0.012 / 0.125);
    EXPECT_NEAR(state_.device_from_stylus.position_m.x, std::sin(a) * reach, 1e-9);
    EXPECT_NEAR(state_.device_from_stylus.position_m.z, std::cos(a) * reach - 0.220, 1e-9);
}

TEST_F(WoodenHapticsDriver, WristRotatesTheNeedleAndItsButtonIsReported) {
    WoodenHaptics driver(time_.clock(), modelWithWrist());
    EXPECT_TRUE(driver.profile().senses_rotation);
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1);
    const Vec3 before = state_.device_from_stylus.direction({0.0, 0.0, 1.0});
    board.turnWristTo({0, 128, 0});  // an eighth of a turn
    hear(driver, kNewestAfter);
    const Vec3 after = state_.device_from_stylus.direction({0.0, 0.0, 1.0});
    EXPECT_NEAR(glm::dot(before, after), std::sqrt(0.5), 1e-9);
    EXPECT_EQ(state_.buttons, 0u);
    board.turnWristTo({10000, 128, 0});
    hear(driver, kNewestAfter);
    EXPECT_EQ(state_.buttons, 1u);
    EXPECT_NEAR(glm::dot(after, state_.device_from_stylus.direction({0.0, 0.0, 1.0})), 1.0, 1e-12);
}

TEST_F(WoodenHapticsDriver, ButtonPressWhileReadyUnhomesAndASecondPressHomes) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1, kPush_n);
    board.pressButton();
    EXPECT_GT(until(driver, DeviceStage::needsHoming, 400, kPush_n), 0);
    const std::uint64_t powered = board.commandLog().powered;
    for (int i = 0; i < 50; ++i)
        ASSERT_EQ(exchange(driver, kPush_n), DeviceStage::needsHoming) << why_;
    board.pressButton();
    EXPECT_GT(until(driver, DeviceStage::ready, 400), 0);
    EXPECT_EQ(board.commandLog().powered, powered);
}

// HZ-FORCE-14
TEST_F(WoodenHapticsDriver, ClosingSendsZeroFirst) {
    WoodenHaptics driver(time_.clock(), model("9.81"));
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 2, kPush_n);
    EXPECT_NE(board.commandLog().motor_ma, (std::array<int, 3>{}));
    driver.close();
    EXPECT_TRUE(test::waitUntil([&] { return board.commandLog().motor_ma == std::array<int, 3>{}; }));
}

// Checks for each fault the driver's reaction, and that few further commands carry current.
class WoodenHapticsFaults : public WoodenHapticsDriver {
  protected:
    // Injects the fault, keeps sending force, and returns the number of powered commands since then.
    std::uint64_t pushThrough(Driver& driver, WoodenHapticsEmulator& board, BoardFault fault, int exchanges) {
        hear(driver, 2, kPush_n);
        const std::uint64_t before = board.commandLog().powered;
        EXPECT_GT(before, 0u);
        board.inject(fault);
        for (int i = 0; i < exchanges && stage_ == DeviceStage::ready; ++i)
            exchange(driver, kPush_n);
        return board.commandLog().powered - before;
    }
};

TEST_F(WoodenHapticsFaults, DroppedReportsEndTheForceAndThenTheConnection) {
    WoodenHaptics driver(time_.clock(), model("9.81"));
    WoodenHapticsEmulator& board = plugInReady(driver);
    const std::uint64_t powered = pushThrough(driver, board, BoardFault::drop, 10);
    EXPECT_LE(powered, kCommandsUntilZero);
    EXPECT_EQ(board.commandLog().motor_ma, (std::array<int, 3>{}));
    EXPECT_EQ(stage_, DeviceStage::ready) << "a moment's silence is not the end";
    EXPECT_NE(why_.find("gives no reports"), std::string::npos) << why_;

    board.inject(BoardFault::none);
    hear(driver, 3, kPush_n);
    EXPECT_EQ(why_, "");
    EXPECT_NE(board.commandLog().motor_ma, (std::array<int, 3>{})) << "it speaks again";

    board.inject(BoardFault::drop);
    EXPECT_GT(until(driver, DeviceStage::failed, 60, kPush_n), 0);
    EXPECT_NE(why_.find("gives no reports"), std::string::npos) << why_;
    driver.close();
}

TEST_F(WoodenHapticsFaults, DuplicatesChangeNothing) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1);
    const Pose before = state_.device_from_stylus;
    board.inject(BoardFault::duplicate);
    for (int i = 0; i < 50; ++i) {
        hear(driver, 1);
        ASSERT_EQ(state_.device_from_stylus.position_m, before.position_m);
    }
}

// HZ-FORCE-21
TEST_F(WoodenHapticsFaults, CorruptEncoderValuesAreRejected) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1);
    const Vec3 before = state_.device_from_stylus.position_m;
    EXPECT_LE(pushThrough(driver, board, BoardFault::corrupt, 20), kCommandsUntilZero);
    EXPECT_EQ(state_.device_from_stylus.position_m, before);
    EXPECT_NE(why_.find("cannot be right"), std::string::npos) << why_;
    EXPECT_GT(until(driver, DeviceStage::failed, 60, kPush_n), 0);
    EXPECT_NE(why_.find("cannot be right"), std::string::npos) << why_;
}

// The hand moves on while the PC stalls. The same motion without a stall is implausible.
TEST_F(WoodenHapticsFaults, MotionWhileThePcStallsIsAccepted) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, kNewestAfter);
    std::array<std::int16_t, 6> counts = board.encoders();
    for (const int turn : {3000, -3000}) {  // 0.9 rad
        counts[2] = std::int16_t(counts[2] + turn);
        time_.advanceTo(time_.now_ns + 200 * kMs);
        board.moveTo({counts[0], counts[1], counts[2]});
        hear(driver, kNewestAfter);
        const Vec3 angles = armAngles_rad(model(), {counts[0], counts[1], counts[2], 0, 0, 0});
        EXPECT_NEAR(state_.device_from_stylus.position_m.y, armPosition_m(model(), angles).z, 1e-12);
    }
    hear(driver, kNewestAfter);
    board.moveTo({counts[0], counts[1], std::int16_t(counts[2] + 3000)});
    EXPECT_GT(until(driver, DeviceStage::failed, 60), 0) << "too far without a stall";
}

// A single garbled word that looks like a button press must not set the encoders to the parked pose.
// HZ-FORCE-11
TEST_F(WoodenHapticsFaults, GarbledButtonDoesNotHomeTheArm) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1);
    const std::array<std::int16_t, 6> before = board.encoders();
    board.injectButton();
    EXPECT_GT(until(driver, DeviceStage::needsHoming, 400, kPush_n), 0);
    for (int i = 0; i < 100; ++i)
        ASSERT_EQ(exchange(driver, kPush_n), DeviceStage::needsHoming) << why_;
    EXPECT_EQ(board.encoders(), before);
    EXPECT_EQ(board.commandLog().motor_ma, (std::array<int, 3>{}));
}

TEST_F(WoodenHapticsFaults, TruncatedReportsAreRejected) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    EXPECT_LE(pushThrough(driver, board, BoardFault::cut, 20), kCommandsUntilZero);
    EXPECT_NE(why_.find("cannot be right"), std::string::npos) << why_;
    EXPECT_GT(until(driver, DeviceStage::failed, 60, kPush_n), 0);
}

TEST_F(WoodenHapticsFaults, SilentBoardIsLostWithin250Ms) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    pushThrough(driver, board, BoardFault::deaf, 0);
    const int exchanges = until(driver, DeviceStage::failed, 60, kPush_n);
    EXPECT_GT(exchanges, 40);
    EXPECT_NE(why_.find("gives no reports"), std::string::npos) << why_;
}

// HZ-FORCE-07
TEST_F(WoodenHapticsFaults, UnpluggingFailsAtOnceAndReconnects) {
    WoodenHaptics driver(time_.clock(), model());
    {
        WoodenHapticsEmulator& board = plugIn();
        makeReady(driver, board);
        hear(driver, 1, kPush_n);
        board.unplug();
        EXPECT_EQ(exchange(driver, kPush_n), DeviceStage::failed);
        EXPECT_NE(why_.find("/dev/hidraw"), std::string::npos) << why_;
        driver.close();
        EXPECT_EQ(driver.open(why_), DeviceStage::absent);
    }
    WoodenHapticsEmulator& again = plugIn();
    stage_ = DeviceStage::absent;
    makeReady(driver, again);
    hear(driver, 1, kPush_n);
}

TEST_F(WoodenHapticsFaults, UnpluggedMidWriteItFailsWithAReason) {
    WoodenHaptics driver(time_.clock(), model());
    WoodenHapticsEmulator& board = plugInReady(driver);
    hear(driver, 1, kPush_n);
    board.block();
    std::thread hand([&] {
        test::sleepMs(50);
        board.unplug();
    });
    EXPECT_EQ(driver.exchange(kPush_n, state_, why_), DeviceStage::failed);
    hand.join();
    EXPECT_NE(why_.find("/dev/hidraw"), std::string::npos) << why_;
    driver.close();
}

// Any mixture of faults: the current never exceeds 2 A, every pose is valid, and silence ends the force.
// HZ-FORCE-21
TEST_F(WoodenHapticsFaults, AnyMixtureOfFaultsStaysSafe) {
    WoodenHaptics driver(time_.clock(), model("9.81"));
    WoodenHapticsEmulator& board = plugInReady(driver);
    std::mt19937 random(11);
    const std::array<BoardFault, 6> kinds{BoardFault::none,      BoardFault::none,    BoardFault::drop,
                                          BoardFault::duplicate, BoardFault::corrupt, BoardFault::cut};
    for (int i = 0; i < 800; ++i) {
        if (i % 5 == 0) board.inject(kinds[random() % kinds.size()]);
        if (exchange(driver, 30.0 * kPush_n) == DeviceStage::failed) {
            EXPECT_NE(why_, "");
            driver.close();
            stage_ = DeviceStage::absent;
            board.inject(BoardFault::none);
            makeReady(driver, board);
        }
        const Pose& pose = state_.device_from_stylus;
        ASSERT_LT(glm::dot(pose.position_m, pose.position_m), 1.0);
        ASSERT_NEAR(glm::dot(pose.rotation, pose.rotation), 1.0, 1e-9);
    }
    EXPECT_LE(board.commandLog().largest_ma, 2000);
    EXPECT_FALSE(board.commandLog().malformed);
}

// The driver behind PolledDevice. The test's thread polls it and advances its clock, so no tick of the loop
// is late.
class PolledWoodenHaptics : public WoodenHapticsDriver {
  protected:
    PolledDevice make() {
        return {std::make_unique<WoodenHaptics>(time_.clock(), model()), time_.clock(),
                PolledSettings{.absent_retry_ns = 20 * kMs, .backoff_first_ns = 20 * kMs}};
    }
    void poll(PolledDevice& device) {
        time_.advancePeriod(settled([&] {
            const std::uint64_t exchanges = device.report().exchanges;
            const std::int64_t due_ns = device.poll();
            // open() sends no command, so it counts as absent.
            stage_ = device.report().exchanges > exchanges ? device.stage() : DeviceStage::absent;
            return due_ns;
        }));
    }
    // Ticks like the loop until `done` returns true. Returns false after a minute.
    bool loop(PolledDevice& device, const auto& done) {
        return test::waitUntil([&] {
            state_ = device.read(time_.now_ns);
            if (done()) return true;
            device.send(kPush_n);
            poll(device);
            return false;
        });
    }
    bool loopUntil(PolledDevice& device, DeviceStage stage) {
        return loop(device, [&] { return device.stage() == stage; });
    }
    void home(PolledDevice& device, WoodenHapticsEmulator& board) {
        ASSERT_TRUE(loopUntil(device, DeviceStage::needsHoming)) << device.report().why;
        const std::uint64_t told = board.commandLog().commands;
        ASSERT_TRUE(loop(device, [&] { return board.commandLog().commands > told + 5; }));
        board.pressButton();
        ASSERT_TRUE(loopUntil(device, DeviceStage::ready)) << device.report().why;
        ASSERT_TRUE(loop(device, [&] { return board.commandLog().motor_ma != std::array<int, 3>{}; }));
    }
};

// HZ-FORCE-06
TEST_F(PolledWoodenHaptics, SilentLoopEndsInZeroCurrent) {
    WoodenHapticsEmulator& board = plugIn();
    PolledDevice device = make();
    home(device, board);
    const std::int64_t spoke_ns = time_.now_ns;
    while (time_.now_ns - spoke_ns < 20 * kMs)
        poll(device);
    EXPECT_EQ(board.commandLog().motor_ma, (std::array<int, 3>{}));
    for (int i = 0; i < 50; ++i)
        poll(device);
    EXPECT_EQ(board.commandLog().motor_ma, (std::array<int, 3>{}));
    EXPECT_EQ(device.report().silences, 1u);
    device.stop();
    EXPECT_EQ(device.stage(), DeviceStage::absent);
}

TEST_F(PolledWoodenHaptics, ReconnectionRequiresHoming) {
    PolledDevice device = make();
    WoodenHapticsEmulator& board = plugIn();
    home(device, board);
    board.unplug();
    EXPECT_TRUE(loop(device, [&] { return (state_.flags & kDeviceReady) == 0; }));
    EXPECT_TRUE(loopUntil(device, DeviceStage::absent)) << device.report().why;
    EXPECT_NE(device.report().why.find("1234:0006"), std::string::npos);
    EXPECT_EQ(device.report().failures, 1u);
    home(device, plugIn());
    EXPECT_NE(state_.flags & kDeviceReady, 0u);
}

}  // namespace
}  // namespace stylet::haptics
