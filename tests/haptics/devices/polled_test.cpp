#include "haptics/devices/polled.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <new>
#include <stdexcept>
#include <vector>

#include "tests/support/constants.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/wait_until.h"
#include "tests/support/wall_clock.h"

namespace stylet::haptics {
namespace {

using test::kMs;

// Behaviour of the scripted device. By default it is ready at once and stays in place.
struct Script {
    std::function<DeviceStage(std::string&)> open = [](std::string&) { return DeviceStage::ready; };
    std::function<DeviceStage(const Vec3&, DeviceState&, std::string&)> exchange =
        [](const Vec3&, DeviceState& state, std::string&) {
            state.fresh = 1;
            return DeviceStage::ready;
        };
    DeviceProfile profile{.name = "scripted", .force_peak_n = 8.0, .source = "test"};
    std::vector<Vec3> forces;  // as received by the bus
    int opened = 0, closed = 0;
};

class ScriptedDriver final : public Driver {
  public:
    explicit ScriptedDriver(Script& script) : script_(&script) {}
    const DeviceProfile& profile() const noexcept override { return script_->profile; }
    DeviceStage open(std::string& why) override {
        ++script_->opened;
        return script_->open(why);
    }
    DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) override {
        script_->forces.push_back(force_n);
        return script_->exchange(force_n, state, why);
    }
    void close() noexcept override { ++script_->closed; }

  private:
    Script* script_;
};

struct Polled : testing::Test {
    Script script;
    test::SteppedClock time;
    PolledDevice device{std::make_unique<ScriptedDriver>(script), time.clock()};

    // Polls whenever due for `span_ns`, and sends `force_n` before each exchange.
    void pollFor(std::int64_t span_ns, const Vec3* force_n = nullptr) {
        const std::int64_t end_ns = time.now_ns + span_ns;
        while (time.now_ns < end_ns) {
            if (force_n) device.send(*force_n);
            time.now_ns = std::min(end_ns, std::max(device.poll(), time.now_ns.load()));
        }
    }
    DeviceState read() { return device.read(0); }
    bool ready() { return (read().flags & kDeviceReady) != 0; }
};

const Vec3 kPush{1.0, -2.0, 0.5};

TEST_F(Polled, ReportsAbsentBeforeTheFirstPoll) {
    EXPECT_EQ(device.stage(), DeviceStage::absent);
    const DeviceState state = read();
    EXPECT_EQ(state.fresh, 0u);
    EXPECT_EQ(state.flags, 0u);
    EXPECT_EQ(script.opened, 0);
}

TEST_F(Polled, ExchangesOnceAPeriodAndPassesForceAndPose) {
    script.exchange = [](const Vec3&, DeviceState& state, std::string&) {
        state.device_from_stylus.position_m = {0.1, 0.2, 0.3};
        state.buttons = 5;
        state.fresh = 1;
        return DeviceStage::ready;
    };
    device.send(kPush);  // a force sent before the device is ready is ignored
    pollFor(10 * kMs);
    EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
    script.forces.clear();
    pollFor(100 * kMs, &kPush);
    EXPECT_NEAR(double(script.forces.size()), 100.0, 1.0);
    EXPECT_THAT(script.forces, testing::Each(kPush));
    const DeviceState state = read();
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.1, 0.2, 0.3));
    EXPECT_EQ(state.buttons, 5u);
    EXPECT_EQ(state.fresh, 1u);
    EXPECT_EQ(state.flags, std::uint32_t(kDeviceReady | kDeviceHandOn));
    EXPECT_EQ(read().fresh, 0u);
    EXPECT_EQ(read().device_from_stylus.position_m, Vec3(0.1, 0.2, 0.3));
}

TEST_F(Polled, ExchangesAtTheDeviceRate) {
    script.profile.rate_hz = 250.0;
    pollFor(100 * kMs);
    EXPECT_NEAR(double(script.forces.size()), 25.0, 1.0);
}

TEST_F(Polled, AbsentDeviceIsSearchedForAgain) {
    bool plugged = false;
    script.open = [&](std::string& why) {
        why = "none of 0403:cb48";
        return plugged ? DeviceStage::ready : DeviceStage::absent;
    };
    pollFor(2001 * kMs);
    EXPECT_EQ(script.opened, 5);  // one attempt every half second
    EXPECT_EQ(script.closed, 0);
    EXPECT_EQ(device.report().why, "none of 0403:cb48");
    EXPECT_EQ(device.report().failures, 0u);
    plugged = true;
    pollFor(501 * kMs);
    EXPECT_EQ(device.stage(), DeviceStage::ready);
    EXPECT_TRUE(ready());
}

TEST_F(Polled, BackOffGrowsWithFailuresAndResetsAfterStableOperation) {
    std::vector<std::int64_t> tries;
    script.open = [&](std::string& why) {
        tries.push_back(time.now_ns);
        why = "no permission";
        return DeviceStage::failed;
    };
    pollFor(30'000 * kMs);
    ASSERT_EQ(tries.size(), 8u);  // at 0, 0.25, 0.75, 1.75, 3.75, 7.75, 15.75 and 23.75 s
    const std::int64_t gaps_ms[] = {250, 500, 1000, 2000, 4000, 8000, 8000};
    for (std::size_t i = 0; i < 7; ++i)
        EXPECT_EQ(tries[i + 1] - tries[i], gaps_ms[i] * kMs);
    EXPECT_EQ(script.closed, 8);
    EXPECT_EQ(device.report().failures, 8u);
    EXPECT_EQ(device.report().why, "no permission");

    // If the device is lost soon after it became ready, the wait stays at its maximum. After two seconds of
    // operation the wait returns to its minimum.
    script.open = [&](std::string&) { return DeviceStage::ready; };
    script.exchange = [&](const Vec3&, DeviceState&, std::string& why) {
        why = "gone";
        return script.forces.size() < 1000 ? DeviceStage::ready : DeviceStage::failed;
    };
    pollFor(10'000 * kMs);
    EXPECT_EQ(device.stage(), DeviceStage::failed);
    const int opened = script.opened;
    script.exchange = Script().exchange;
    pollFor(3'000 * kMs);
    EXPECT_EQ(script.opened, opened + 1);
    EXPECT_EQ(device.stage(), DeviceStage::ready);
    script.exchange = [](const Vec3&, DeviceState&, std::string&) { return DeviceStage::failed; };
    pollFor(300 * kMs);
    EXPECT_EQ(script.opened, opened + 2);
}

TEST_F(Polled, UnpluggedItLosesItsFlagsAndKeepsItsPose) {
    bool plugged = true;
    script.open = [&](std::string&) { return plugged ? DeviceStage::ready : DeviceStage::absent; };
    script.exchange = [&](const Vec3&, DeviceState& state, std::string& why) {
        state.device_from_stylus.position_m = {0.0, 0.0, 0.11};
        state.fresh = 1;
        why = plugged ? "" : "unplugged";
        return plugged ? DeviceStage::ready : DeviceStage::failed;
    };
    pollFor(50 * kMs, &kPush);
    ASSERT_TRUE(ready());
    plugged = false;
    pollFor(2 * kMs, &kPush);
    DeviceState state = read();
    EXPECT_EQ(state.flags, 0u);
    EXPECT_EQ(state.fresh, 1u);  // the loss is reported once
    EXPECT_EQ(read().fresh, 0u);
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.0, 0.0, 0.11));
    EXPECT_EQ(script.closed, 1);
    EXPECT_EQ(device.report().why, "unplugged");
    EXPECT_EQ(device.report().failures, 1u);

    plugged = true;
    device.send(kPush);
    script.forces.clear();
    pollFor(1000 * kMs);
    EXPECT_TRUE(ready());
    EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
    pollFor(2 * kMs, &kPush);
    EXPECT_EQ(script.forces.back(), kPush);
}

TEST_F(Polled, ForceIsSentOnlyWhenReady) {
    DeviceStage stage = DeviceStage::needsFirmware;
    script.open = [&](std::string&) { return DeviceStage::opening; };
    script.exchange = [&](const Vec3&, DeviceState& state, std::string& why) {
        why = "pull the grip out, then push it in";
        state.fresh = 1;
        return stage;
    };
    for (const DeviceStage waiting : {DeviceStage::needsFirmware, DeviceStage::needsHoming}) {
        stage = waiting;
        pollFor(30 * kMs, &kPush);
        EXPECT_EQ(device.stage(), waiting);
        EXPECT_EQ(device.report().why, "pull the grip out, then push it in");
        EXPECT_FALSE(ready());
        EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
    }
    stage = DeviceStage::ready;
    pollFor(30 * kMs, &kPush);
    EXPECT_TRUE(ready());
    EXPECT_EQ(script.forces.back(), kPush);
    stage = DeviceStage::needsHoming;  // the device cleared its homing bit
    pollFor(2 * kMs, &kPush);
    EXPECT_FALSE(ready());
    script.forces.clear();
    pollFor(30 * kMs, &kPush);
    EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
}

// HZ-FORCE-06
TEST_F(Polled, SilentLoopEndsInZeroForceAndIsReported) {
    pollFor(50 * kMs, &kPush);
    script.forces.clear();
    pollFor(19 * kMs);  // no force is sent
    EXPECT_EQ(script.forces[13], kPush);
    EXPECT_EQ(script.forces[16], Vec3(0.0));
    EXPECT_FALSE(ready());
    EXPECT_EQ(device.stage(), DeviceStage::ready);  // the device itself still works
    EXPECT_EQ(device.report().silences, 1u);
    pollFor(1000 * kMs);
    EXPECT_EQ(device.report().silences, 1u);
    EXPECT_FALSE(ready());

    pollFor(2 * kMs, &kPush);
    EXPECT_EQ(script.forces.back(), kPush);
    EXPECT_TRUE(ready());
}

// Runs the loop's check of the device for `ticks` of 1 ms and returns every fault bit. The device's thread
// runs as it would only if `polls`; the loop sends a force in each tick only if `sends`.
struct PolledFaults : Polled {
    SafetyState safety;
    std::uint32_t faultsOver(int ticks, bool polls, bool sends = true) {
        std::uint32_t bits = 0;
        for (int i = 0; i < ticks; ++i) {
            if (sends) device.send(kPush);
            time.now_ns += kMs;
            if (polls) device.poll();
            bits |= checkDevice(safety, script.profile, read(), 0.001);
        }
        return bits;
    }
};

// HZ-FORCE-06
TEST_F(PolledFaults, SilenceOfALateComputerIsNotTheDevices) {
    faultsOver(50, true);
    ASSERT_EQ(faultsOver(50, true), 0u);
    EXPECT_EQ(faultsOver(30, false), std::uint32_t(kFaultHostLate)) << "nobody polled the device";
    EXPECT_EQ(faultsOver(1, true) & (kFaultStaleInput | kFaultDeviceLost), 0u);
    EXPECT_EQ(faultsOver(50, true), 0u);
    EXPECT_EQ(device.report().failures, 0u);
}

// HZ-FORCE-06
TEST_F(PolledFaults, SilenceOfAPolledDeviceIsItsOwn) {
    faultsOver(50, true);
    script.exchange = [](const Vec3&, DeviceState&, std::string&) { return DeviceStage::ready; };  // no data
    EXPECT_EQ(faultsOver(30, true), std::uint32_t(kFaultStaleInput));
}

// The silence is told by its larger part.
TEST_F(PolledFaults, AShortStallInALongSilenceIsNoExcuse) {
    faultsOver(50, true);
    script.exchange = [](const Vec3&, DeviceState&, std::string&) { return DeviceStage::ready; };
    EXPECT_EQ(faultsOver(8, false), 0u);
    EXPECT_EQ(faultsOver(22, true), std::uint32_t(kFaultStaleInput));
}

TEST_F(PolledFaults, ADriverThatDoesNotReturnIsTheDevicesSilence) {
    faultsOver(50, true);
    std::uint32_t bits = 0;
    script.exchange = [&](const Vec3&, DeviceState&, std::string&) {
        for (int i = 0; i < 40; ++i) {  // the loop's ticks during the call
            time.now_ns += kMs;
            bits |= checkDevice(safety, script.profile, read(), 0.001);
        }
        return DeviceStage::ready;
    };
    device.poll();
    EXPECT_EQ(bits, std::uint32_t(kFaultStaleInput));
}

TEST_F(PolledFaults, AnUnpluggedDeviceIsLostEvenOnALateComputer) {
    faultsOver(50, true);
    script.exchange = [](const Vec3&, DeviceState&, std::string& why) {
        why = "unplugged";
        return DeviceStage::failed;
    };
    script.open = [](std::string&) { return DeviceStage::absent; };
    faultsOver(5, false);
    EXPECT_NE(faultsOver(1, true) & kFaultDeviceLost, 0u);
    EXPECT_EQ(faultsOver(60, false) & kFaultHostLate, 0u) << "nothing is due while it is searched for";
}

// The watchdog releases the force of a silent loop. The device is neither unplugged nor in need of homing.
TEST_F(PolledFaults, ASilentLoopIsALateComputer) {
    faultsOver(50, true);
    EXPECT_EQ(faultsOver(30, true, false), std::uint32_t(kFaultHostLate));
    faultsOver(2, true);
    EXPECT_EQ(faultsOver(10, true), 0u);
}

TEST_F(PolledFaults, WithoutForceThereIsNothingToRelease) {
    script.profile = inputOnlyProfile("mouse", "input only");
    faultsOver(50, true);
    EXPECT_EQ(faultsOver(500, true, false), 0u);
    EXPECT_EQ(device.report().silences, 0u);
    EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
}

TEST_F(Polled, DeviceIsReadyBeforeTheFirstForce) {
    pollFor(500 * kMs);
    EXPECT_TRUE(ready());
    EXPECT_EQ(device.report().silences, 0u);
}

// HZ-FORCE-03
TEST_F(Polled, NonFiniteForceIsSentAsZero) {
    const double bad[] = {std::nan(""), std::numeric_limits<double>::infinity()};
    for (const double value : bad) {
        const Vec3 force{0.0, value, 0.0};
        pollFor(20 * kMs, &force);
        EXPECT_THAT(script.forces, testing::Each(Vec3(0.0)));
    }
}

TEST_F(Polled, DriverExceptionIsAFailureWithAReason) {
    const std::function<DeviceStage()> throws[] = {
        []() -> DeviceStage { throw std::runtime_error("bus said no"); },
        []() -> DeviceStage { throw std::bad_alloc(); },
        []() -> DeviceStage { throw 7; },
    };
    const char* reasons[] = {"bus said no", "bad_alloc", "is no exception"};
    for (int i = 0; i < 3; ++i) {
        script.exchange = [&](const Vec3&, DeviceState&, std::string&) { return throws[i](); };
        script.open = [](std::string&) { return DeviceStage::ready; };
        while (device.stage() == DeviceStage::failed)
            pollFor(100 * kMs);
        pollFor(2 * kMs);
        EXPECT_EQ(device.stage(), DeviceStage::failed);
        EXPECT_THAT(device.report().why, testing::HasSubstr(reasons[i]));
        script.open = [&](std::string&) { return throws[i](); };
        pollFor(10'000 * kMs);
        EXPECT_THAT(device.report().why, testing::HasSubstr(reasons[i]));
        script.exchange = Script().exchange;
        script.open = Script().open;
        pollFor(10'000 * kMs);
        ASSERT_EQ(device.stage(), DeviceStage::ready);
    }
    EXPECT_EQ(script.closed, script.opened - 1);
}

// HZ-FORCE-15
TEST_F(Polled, ClockJumpZeroesTheForceWithoutDelay) {
    pollFor(50 * kMs, &kPush);
    for (const std::int64_t jump_ns : {3600'000 * kMs, -3600'000 * kMs, -50 * kMs}) {
        time.now_ns += jump_ns;
        script.forces.clear();
        pollFor(5 * kMs);
        ASSERT_GE(script.forces.size(), 5u) << jump_ns;
        EXPECT_THAT(script.forces, testing::Each(Vec3(0.0))) << jump_ns;
        pollFor(50 * kMs, &kPush);
        EXPECT_NEAR(double(script.forces.size()), 55.0, 2.0) << jump_ns;
        EXPECT_EQ(script.forces.back(), kPush);
    }
    // The clock is set back during the wait for the next attempt.
    script.exchange = [](const Vec3&, DeviceState&, std::string&) { return DeviceStage::failed; };
    pollFor(5 * kMs);
    script.exchange = Script().exchange;
    time.now_ns -= 3600'000 * kMs;
    pollFor(8'000 * kMs + 10 * kMs);
    EXPECT_EQ(device.stage(), DeviceStage::ready);
}

TEST_F(Polled, ProfileIsFixedWhenFirstReadyAndChangesAreRefused) {
    script.profile.force_peak_n = kUnknown;
    script.open = [&](std::string&) {
        script.profile.force_peak_n = 3.3;  // as if learned from a bridge
        return DeviceStage::ready;
    };
    EXPECT_EQ(device.profile().force_peak_n, 8.0);
    pollFor(5 * kMs);
    EXPECT_EQ(device.profile().force_peak_n, 3.3);

    script.exchange = [](const Vec3&, DeviceState&, std::string&) { return DeviceStage::failed; };
    pollFor(5 * kMs);
    script.exchange = Script().exchange;
    script.open = [&](std::string&) {
        script.profile.force_peak_n = 22.0;
        return DeviceStage::ready;
    };
    pollFor(1000 * kMs);
    EXPECT_EQ(device.stage(), DeviceStage::failed);
    EXPECT_THAT(device.report().why, testing::HasSubstr("other limits"));
    EXPECT_EQ(device.profile().force_peak_n, 3.3);
}

TEST_F(Polled, EveryStageHasAName) {
    for (int i = 0; i <= int(DeviceStage::failed); ++i)
        EXPECT_NE(enumName(kDeviceStageNames, DeviceStage(i)), "?");
}

// With real threads, on the machine's clock.
TEST(PolledThread, PassesWholeStatesAndForcesBetweenThreads) {
    std::atomic<int> torn{0}, forces{0};
    Script script;
    double n = 0.0;
    script.exchange = [&](const Vec3& f, DeviceState& state, std::string&) {
        torn += f.x != f.y || f.y != f.z;
        forces += f.x != 0.0;
        state.device_from_stylus.position_m = Vec3(++n);
        state.fresh = 1;
        return DeviceStage::ready;
    };
    PolledDevice device(std::make_unique<ScriptedDriver>(script), test::kWallClock);
    device.start();
    double last = 0.0;
    int i = 0;
    const auto enough = [&] {
        const DeviceState state = device.read(0);
        const Vec3& p = state.device_from_stylus.position_m;
        EXPECT_TRUE(p.x == p.y && p.y == p.z);
        EXPECT_GE(p.x, last);
        last = p.x;
        device.send(Vec3(double(++i)));
        return i >= 300 && forces > 50 && last > 50.0;
    };
    EXPECT_TRUE(test::waitUntil(enough));
    device.stop();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(script.closed, 1);
    EXPECT_EQ(device.read(0).flags, 0u);
    device.stop();
    EXPECT_EQ(script.closed, 1);
    device.start();  // a second start
    EXPECT_TRUE(test::waitUntil([&] { return device.stage() == DeviceStage::ready; }));
}

TEST(PolledThread, BlockedDriverDoesNotBlockTheLoop) {
    std::atomic<bool> blocks{false}, blocked{false};
    Script script;
    script.exchange = [&](const Vec3&, DeviceState& state, std::string&) {
        while (blocks) {
            blocked = true;
            test::sleepMs(1);
        }
        blocked = false;
        state.fresh = 1;
        return DeviceStage::ready;
    };
    PolledDevice device(std::make_unique<ScriptedDriver>(script), test::kWallClock);
    device.start();
    ASSERT_TRUE(test::waitUntil([&] { return device.stage() == DeviceStage::ready; }));
    blocks = true;
    ASSERT_TRUE(test::waitUntil([&] { return blocked.load(); }));
    ASSERT_TRUE(test::waitUntil([&] { return device.report().blocked_ns >= kDriverDeadline_ns; }));
    device.read(0);
    std::int64_t worst_ns = 0;
    // These calls return while the driver is inside its own call: they do not wait for it.
    for (int i = 0; i < 1000; ++i) {
        const std::int64_t began_ns = test::wallNow_ns();
        EXPECT_EQ(device.read(0).fresh, 0u);  // the loop's stale-input check counts this
        device.send(kPush);
        worst_ns = std::max(worst_ns, test::wallNow_ns() - began_ns);
    }
    EXPECT_TRUE(blocked);
    RecordProperty("worst_us", int(worst_ns / 1000));
    EXPECT_GE(device.report().blocked_ns, kDriverDeadline_ns);
    blocks = false;
    ASSERT_TRUE(test::waitUntil([&] { return device.read(0).fresh != 0; }));
    EXPECT_TRUE(test::waitUntil([&] { return device.report().blocked_ns == 0; }));
}

TEST(PolledThread, StopTakesEffectWhileWaitingForADevice) {
    Script script;
    script.open = [](std::string&) { return DeviceStage::absent; };
    PolledSettings settings;
    settings.absent_retry_ns = 3600'000 * kMs;
    PolledDevice device(std::make_unique<ScriptedDriver>(script), test::kWallClock, settings);
    device.start();
    ASSERT_TRUE(test::waitUntil([&] { return device.report().opens > 0; }));
    const std::int64_t began_ns = test::wallNow_ns();
    device.stop();
    EXPECT_LT(test::wallNow_ns() - began_ns, 60'000 * kMs);  // the next attempt is an hour away
}

}  // namespace
}  // namespace stylet::haptics
