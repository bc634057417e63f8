#include "haptics/devices/bridge/serve_linux.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include "haptics/devices/bridge/bridge.h"
#include "tests/support/bridge_simulated.h"
#include "tests/support/constants.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wait_until.h"

namespace stylet::haptics::bridge {
namespace {

using test::kTick_ns;

struct ServoRun {
    Vec3 tick() {
        now_ns += kTick_ns;
        return servo.tick({now_ns, {}, 0, MotorStage::on, true}, 3.3);
    }
    void command(const Vec3& force_n) { servo.command({now_ns, force_n}); }
    // A force of zero, after which other forces are applied.
    void arm() {
        command(Vec3(0.0));
        tick();
    }
    bool watchdog() {
        Sample sample;
        bool tripped = false;
        EXPECT_TRUE(servo.readSample(sample, tripped));
        return tripped;
    }
    Servo servo;
    std::int64_t now_ns = 1'000'000'000;
};

TEST(BridgeServo, AppliesZeroUntilAZeroCommandArrives) {
    ServoRun run;
    EXPECT_EQ(run.tick(), Vec3(0.0));
    run.command({0.0, 0.0, 1.0});
    EXPECT_EQ(run.tick(), Vec3(0.0));
    EXPECT_TRUE(run.watchdog());
    run.command({0.0, 0.0, 0.0});
    EXPECT_EQ(run.tick(), Vec3(0.0));
    EXPECT_FALSE(run.watchdog());
    run.command({0.0, 0.0, 1.0});
    EXPECT_EQ(run.tick(), Vec3(0.0, 0.0, 1.0));
}

// HZ-FORCE-06
TEST(BridgeServo, FifteenMillisecondsOfSilenceRemoveTheForce) {
    ServoRun run;
    run.arm();
    run.command({1.0, 0.0, 0.0});
    for (int i = 1; i <= 15; ++i)
        EXPECT_EQ(run.tick(), Vec3(1.0, 0.0, 0.0)) << i;
    EXPECT_EQ(run.tick(), Vec3(0.0));
    run.command({1.0, 0.0, 0.0});  // commands are back, but a zero force must come first
    EXPECT_EQ(run.tick(), Vec3(0.0));
    EXPECT_TRUE(run.watchdog());
}

// HZ-FORCE-15
TEST(BridgeServo, ForceWithImplausibleTimestampIsIgnored) {
    ServoRun run;
    run.arm();
    run.servo.command({run.now_ns + 1'000 * kTick_ns, {1.0, 0.0, 0.0}});
    EXPECT_EQ(run.tick(), Vec3(0.0));
    run.arm();
    run.servo.command({run.now_ns - 30 * kTick_ns, {1.0, 0.0, 0.0}});
    EXPECT_EQ(run.tick(), Vec3(0.0));
}

// HZ-FORCE-01
TEST(BridgeServo, ForceIsClampedToDevicePeakKeepingDirection) {
    ServoRun run;
    run.arm();
    run.command({30.0, 40.0, 0.0});
    const Vec3 sent_n = run.tick();
    EXPECT_NEAR(sent_n.x, 3.3 * 0.6, 1e-12);
    EXPECT_NEAR(sent_n.y, 3.3 * 0.8, 1e-12);
}

TEST(BridgeServo, ReleaseAppliesZeroInTheNextTick) {
    ServoRun run;
    run.arm();
    run.command({1.0, 0.0, 0.0});
    run.tick();
    run.servo.release();
    EXPECT_EQ(run.tick(), Vec3(0.0));
}

struct Conversation {
    Conversation() { putText(capabilities.name, "x"), capabilities.profile.force_peak_n = 3.3; }
    // Sends a frame to the session and reads its answer.
    LinkFault say(const FrameBytes& bytes, Frame& answer) {
        out.clear();
        on = session.receive(bytes.span(), out);
        return readFrame(out, answer);
    }
    std::string lastWords(std::span<const std::uint8_t> bytes) {
        out.clear();
        on = session.receive(bytes, out);
        Frame frame;
        Bye bye;
        EXPECT_EQ(readFrame(out, frame), LinkFault::none);
        EXPECT_EQ(parse(frame, bye), LinkFault::none);
        return bye.reason.data();
    }
    Capabilities capabilities;
    Servo servo;
    Session session{capabilities, servo};
    std::vector<std::uint8_t> out;
    bool on = true;
};

TEST(BridgeSession, GreetsAndAnswersEachForceWithTheNewestSample) {
    Conversation talk;
    Frame frame;
    ASSERT_EQ(talk.say(encode(1, Hello{}), frame), LinkFault::none);
    EXPECT_EQ(frame.type, FrameType::capabilities);
    ASSERT_EQ(talk.say(encode(2, Force{}), frame), LinkFault::none);
    EXPECT_EQ(frame.bytes, 0u);  // no sample yet, so nothing to send
    talk.servo.tick({7, {Quat(1.0, 0.0, 0.0, 0.0), Vec3(0.1, 0.2, 0.3)}, 5, MotorStage::on, true}, 3.3);
    ASSERT_EQ(talk.say(encode(3, Force{}), frame), LinkFault::none);
    State state;
    ASSERT_EQ(parse(frame, state), LinkFault::none);
    EXPECT_EQ(state.answers, 3u);
    EXPECT_EQ(state.sampled_ns, 7);
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.1, 0.2, 0.3));
    EXPECT_EQ(state.buttons, 5u);
    EXPECT_EQ(frame.sequence, 2u);
}

TEST(BridgeSession, RefusesWithAReason) {
    EXPECT_EQ(Conversation().lastWords(encode(1, Hello{2, 3}).span()), describe(LinkFault::version));
    EXPECT_EQ(Conversation().lastWords(encode(1, Force{}).span()), describe(LinkFault::unexpected));
    FrameBytes flipped = encode(1, Hello{});
    flipped.bytes[9] ^= 1;
    EXPECT_EQ(Conversation().lastWords(flipped.span()), describe(LinkFault::checksum));
    const std::uint8_t noise[] = {'G', 'E', 'T', ' '};
    EXPECT_EQ(Conversation().lastWords(noise), describe(LinkFault::magic));
    Conversation talk;
    Frame frame;
    talk.say(encode(1, Hello{}), frame);
    EXPECT_EQ(talk.lastWords(encode(2, Force{0, {std::nan(""), 0.0, 0.0}}).span()),
              describe(LinkFault::value));
    EXPECT_FALSE(talk.on);
}

TEST(BridgeSession, AcceptsFramesInPiecesAndIgnoresDuplicates) {
    Conversation talk;
    talk.servo.tick({7, {}, 0, MotorStage::on, true}, 3.3);
    std::vector<std::uint8_t> in;
    for (const FrameBytes& frame :
         {encode(1, Hello{}), encode(2, Force{}), encode(2, Force{}), encode(3, Force{})})
        in.insert(in.end(), frame.span().begin(), frame.span().end());
    for (const std::uint8_t byte : in)
        ASSERT_TRUE(talk.session.receive({&byte, 1}, talk.out));
    EXPECT_EQ(talk.out.size(), 256u + 2 * 96u);
}

// serve() runs on its own thread, with the driver as its client. The device's servo runs on the test's
// thread. The clock stands still while serve() answers, so a stall of the test machine does not count as
// silence.
class BridgeServe : public testing::Test {
  protected:
    void SetUp() override {
        thread = std::thread([this] { why = serve(sdk, path, stop); });
        ASSERT_TRUE(test::waitUntil([this] { return sdk.running(); }));
        tick();
    }
    void TearDown() override { finish(); }
    std::string finish() {
        stop.store(true);
        if (thread.joinable()) thread.join();
        return why;
    }
    bool tick() { return sdk.tick(time.now_ns += kTick_ns); }
    // One servo tick, then one exchange.
    DeviceStage exchange(BridgeDriver& driver, const Vec3& force_n = Vec3(0.0)) {
        tick();
        state.fresh = 0;
        return driver.exchange(force_n, state, reason);
    }
    // Exchanges until the force reaches the motors.
    void press(BridgeDriver& driver) {
        DeviceStage stage = DeviceStage::opening;
        for (int i = 0; i < 10 && sdk.motor_n() == 0.0; ++i) {
            stage = exchange(driver, {0.0, 0.0, stage == DeviceStage::ready ? 1.0 : 0.0});
            ASSERT_NE(stage, DeviceStage::failed) << reason;
        }
        ASSERT_EQ(sdk.motor_n(), 1.0);
    }

    test::TempFolder folder;
    std::string path = folder / "bridge.sock";
    test::SteppedClock time;
    test::SimulatedSdk sdk{test::SimulatedSdk::Ticks::test};
    std::atomic<bool> stop{false};
    DeviceState state;
    std::string why, reason;  // reasons from serve() and from the driver
    std::thread thread;
};

TEST_F(BridgeServe, DriverReceivesSdkState) {
    BridgeDriver driver(time.clock(), {.socket_path = path});
    ASSERT_EQ(driver.open(reason), DeviceStage::opening) << reason;
    EXPECT_STREQ(driver.profile().name, "simulated Touch");
    EXPECT_EQ(driver.profile().stiffness_n_per_m, 400.0);
    press(driver);
    ASSERT_EQ(exchange(driver, {0.0, 0.0, 1.0}), DeviceStage::ready) << reason;
    EXPECT_EQ(state.fresh, 1u);
    const Vec3 p = state.device_from_stylus.position_m;
    EXPECT_NEAR(std::hypot(p.x, p.y), 0.02, 1e-9);
}

// HZ-FORCE-14
TEST_F(BridgeServe, ClosedOrSilentTrainerEndsInZeroForce) {
    BridgeDriver driver(time.clock(), {.socket_path = path});
    ASSERT_EQ(driver.open(reason), DeviceStage::opening) << reason;
    press(driver);
    driver.close();
    // Time stands still, so the bye frame ends the force, not the watchdog.
    EXPECT_TRUE(test::waitUntil([this] { return sdk.tick(time.now_ns) && sdk.motor_n() == 0.0; }));

    ASSERT_TRUE(test::waitUntil([&] { return driver.open(reason) == DeviceStage::opening; })) << reason;
    press(driver);
    const std::int64_t spoke_ns = time.now_ns;  // the driver sends nothing after this time
    for (int i = 0; i < 100; ++i)
        tick();
    EXPECT_EQ(sdk.motor_n(), 0.0);
    EXPECT_EQ(sdk.last_force_ns() - spoke_ns, kSilenceTimeout_ns);
    EXPECT_EQ(exchange(driver, {0.0, 0.0, 1.0}), DeviceStage::opening);
    EXPECT_EQ(reason, "the bridge's watchdog cut the force");
    EXPECT_EQ(state.flags, kDeviceHandOn);
}

TEST_F(BridgeServe, UnpluggedDeviceIsReported) {
    BridgeDriver driver(time.clock(), {.socket_path = path});
    ASSERT_EQ(driver.open(reason), DeviceStage::opening) << reason;
    press(driver);
    sdk.unplug();
    EXPECT_FALSE(tick());
    thread.join();
    EXPECT_EQ(why, "the device was unplugged");
    EXPECT_EQ(driver.exchange({}, state, reason), DeviceStage::failed);
    EXPECT_EQ(reason, "the bridge closed: the device was unplugged");
    EXPECT_EQ(driver.open(reason), DeviceStage::absent);
}

TEST_F(BridgeServe, SecondTrainerIsRefused) {
    BridgeDriver first(time.clock(), {.socket_path = path}), second(time.clock(), {.socket_path = path});
    ASSERT_EQ(first.open(reason), DeviceStage::opening) << reason;
    EXPECT_EQ(second.open(reason), DeviceStage::failed);
    EXPECT_EQ(reason, "the bridge closed: another trainer is connected");
    press(first);
}

TEST_F(BridgeServe, SecondBridgeIsRefusedAndStaleSocketIsReplaced) {
    std::atomic<bool> never{true};
    test::SimulatedSdk other;
    EXPECT_EQ(serve(other, path, never), path + ": another bridge listens there");
    finish();
    EXPECT_FALSE(std::filesystem::exists(path));

    const std::string left = folder / "left.sock";
    {
        // The socket file of a dead process remains in the file system.
        sockaddr_un address;
        ASSERT_TRUE(makeAddress(left, address, reason)) << reason;
        const Descriptor dead(::socket(AF_UNIX, SOCK_STREAM, 0));
        ASSERT_EQ(::bind(dead, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    }
    EXPECT_EQ(serve(other, left, never), "");
    std::ofstream(folder / "file.sock") << "not a socket";
    EXPECT_NE(serve(other, folder / "file.sock", never), "");
    EXPECT_TRUE(std::filesystem::exists(folder / "file.sock"));
}

TEST_F(BridgeServe, MissingDeviceIsReported) {
    finish();
    sdk.missing.store(true);
    EXPECT_EQ(serve(sdk, path, stop), "no device is plugged in");
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace stylet::haptics::bridge
