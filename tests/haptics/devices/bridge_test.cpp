#include "haptics/devices/bridge/bridge.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptics/devices/bridge/protocol.h"
#include "haptics/devices/polled.h"
#include "haptics/haptics.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/constants.h"
#include "tests/support/phantom.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/temp_folder.h"
#include "tests/support/wait_until.h"
#include "tests/support/wall_clock.h"

extern char** environ;

namespace stylet::haptics {
namespace {

using test::BridgeFault;
using test::BridgeScript;
using test::BridgeServer;
using test::kMs;
using test::SteppedClock;

// The driver and the emulator on a clock that the test advances by one millisecond per exchange. The clock
// stands still while the emulator answers, so a stall of the test machine does not count as silence of the
// bridge.
class BridgeDriverTest : public testing::Test {
  protected:
    // Opens the driver, then exchanges once per millisecond and sends force when ready, until an exchange
    // fails. Returns the reason.
    std::string pressUntilItFails(BridgeDriver& driver, int most = 400) {
        std::string why;
        if (driver.open(why) != DeviceStage::opening) return why;
        DeviceStage stage = DeviceStage::opening;
        for (int i = 0; i < most; ++i) {
            began_ns = time.now_ns += kMs;
            stage = driver.exchange({0.0, 0.0, stage == DeviceStage::ready ? 1.0 : 0.0}, state, why);
            if (stage == DeviceStage::failed) return why;
            ready = ready || stage == DeviceStage::ready;
        }
        return "did not fail";
    }
    // The script with its times on the driver's clock.
    BridgeScript timed(BridgeScript script) {
        script.time_ns = &time.now_ns;
        return script;
    }

    test::TempFolder folder;
    std::string path = folder / "bridge.sock";
    SteppedClock time;
    DeviceState state;
    std::int64_t began_ns = 0;  // start of the last exchange
    bool ready = false;
};

TEST_F(BridgeDriverTest, WithoutABridgeTheDeviceIsAbsent) {
    BridgeDriver driver(time.clock(), {.socket_path = path});
    std::string why;
    EXPECT_EQ(driver.open(why), DeviceStage::absent);
    EXPECT_EQ(why, "no bridge listens on " + path);
    EXPECT_EQ(driver.profile().force_peak_n, 3.3);  // the weakest device, until a bridge answers
    BridgeDriver long_path(time.clock(), {.socket_path = std::string(200, 'x')});
    EXPECT_EQ(long_path.open(why), DeviceStage::failed);
}

TEST_F(BridgeDriverTest, ReadsEmulatorStateAndSendsForce) {
    BridgeServer server(path, timed({}));
    BridgeDriver driver(time.clock(), {.socket_path = path});
    EXPECT_EQ(pressUntilItFails(driver, 50), "did not fail");
    EXPECT_TRUE(ready);
    EXPECT_EQ(server.commanded_n(), 1.0);
    EXPECT_STREQ(driver.profile().name, "emulated Touch");
    EXPECT_STREQ(driver.profile().source, "emulator");
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.0, 0.0, 0.1));
    EXPECT_EQ(state.flags, kDeviceReady | kDeviceHandOn);
    driver.close();
    EXPECT_TRUE(test::waitUntil([&] { return server.receivedBye(); }));
    EXPECT_EQ(server.motor_n(), 0.0);
}

TEST_F(BridgeDriverTest, EveryFaultFailsWithItsReason) {
    const std::pair<BridgeFault, const char*> cases[] = {
        {BridgeFault::drop, "nothing from the bridge for 15 ms"},
        {BridgeFault::stall, "nothing from the bridge for 15 ms"},
        {BridgeFault::disconnect, "the bridge is gone"},
        {BridgeFault::notFinite, "a value that is not finite or out of range"},
        {BridgeFault::future, "a sample's time went back or is in the future"},
        {BridgeFault::past, "a sample's time went back or is in the future"},
        {BridgeFault::frozen, "no new sample from the device for 15 ms"},
        {BridgeFault::tooLong, "a frame of the wrong length"},
        {BridgeFault::version, "another version of the protocol"},
        {BridgeFault::garbage, "a frame does not begin with STBG"},
    };
    for (const auto& [fault, name] : cases) {
        const BridgeScript script = {
            .fault = fault, .from_answer = 20, .answers = 1000, .stall_ns = 1'000'000'000};
        BridgeServer server(path, timed(script));
        BridgeDriver driver(time.clock(), {.socket_path = path});
        ready = false;
        EXPECT_EQ(pressUntilItFails(driver), name);
        EXPECT_TRUE(ready);
    }
}

// Measures the driver's time from the first faulty answer to the failure. Only the driver's own waits count.
TEST_F(BridgeDriverTest, FaultIsDetectedWithin20Ms) {
    for (const BridgeFault fault :
         {BridgeFault::drop, BridgeFault::stall, BridgeFault::disconnect, BridgeFault::corrupt}) {
        std::int64_t longest_ns = 0;
        for (std::uint32_t run = 0; run < 7; ++run) {
            BridgeServer server(path, timed({.fault = fault,
                                             .from_answer = 20,
                                             .answers = 1000,
                                             .stall_ns = 1'000'000'000,
                                             .seed = 10 + run}));
            BridgeDriver driver(time.clock(), {.socket_path = path});
            ready = false;
            ASSERT_NE(pressUntilItFails(driver), "did not fail");
            EXPECT_TRUE(ready);
            ASSERT_TRUE(test::waitUntil([&] { return server.fault_began_ns() != 0; }));
            longest_ns =
                std::max(longest_ns, began_ns + BridgeSettings().answer_ns - server.fault_began_ns());
        }
        EXPECT_LE(longest_ns, 20 * kMs) << int(fault);
        RecordProperty("us_of_fault_" + std::to_string(int(fault)), int(longest_ns / 1000));
    }
}

// Before the first answer the device's pose is unknown. The pose stays unchanged and is not marked fresh.
TEST_F(BridgeDriverTest, BeforeTheFirstAnswerThereIsNoPose) {
    BridgeServer server(path, timed({.fault = BridgeFault::drop, .from_answer = 0, .answers = 1000}));
    BridgeDriver driver(time.clock(), {.socket_path = path});
    std::string why;
    ASSERT_EQ(driver.open(why), DeviceStage::opening) << why;
    state = {.device_from_stylus = {Quat(0.0, 1.0, 0.0, 0.0), {0.1, 0.2, 0.3}}, .buttons = 5, .fresh = 0};
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::opening);
    EXPECT_EQ(why, "the bridge has not answered yet");
    EXPECT_EQ(state.device_from_stylus.position_m, Vec3(0.1, 0.2, 0.3));
    EXPECT_EQ(state.device_from_stylus.rotation, Quat(0.0, 1.0, 0.0, 0.0));
    EXPECT_EQ(state.buttons, 5u);
    EXPECT_EQ(state.fresh, 0u);
    EXPECT_EQ(state.flags, 0u);
}

// Sends one valid frame repeatedly, as fast as possible, until the other side hangs up.
void floodOnce(int listener) {
    const Descriptor client(::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC));
    bridge::Capabilities capabilities;
    bridge::putText(capabilities.name, "a flood");
    const bridge::FrameBytes frame = encode(1, capabilities);
    std::vector<std::uint8_t> many;
    for (int i = 0; i < 100; ++i)
        many.insert(many.end(), frame.span().begin(), frame.span().end());
    while (::send(client, many.data(), many.size(), MSG_NOSIGNAL) == ssize_t(many.size())) {
    }
}

// The flood never ends and the driver's clock stands still, so no timeout can end it. The driver must end
// it.
TEST_F(BridgeDriverTest, FloodFailsWithoutBlocking) {
    const Descriptor listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_un address;
    std::string why;
    ASSERT_TRUE(makeAddress(path, address, why)) << why;
    ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(listener, 1), 0);
    const std::int64_t wall_ns = test::monotonicNow_ns();
    std::thread flood([&] { floodOnce(listener); });
    {
        BridgeDriver driver(time.clock(), {.socket_path = path});
        why = pressUntilItFails(driver, 1);
    }
    flood.join();
    EXPECT_EQ(why, "the bridge sent more data than its answers can be: restart it");
    RecordProperty("wall_us", int((test::monotonicNow_ns() - wall_ns) / 1000));
}

TEST_F(BridgeDriverTest, DifferentDeviceIsRefusedOnReconnect) {
    BridgeDriver driver(time.clock(), {.socket_path = path});
    std::string why;
    {
        BridgeServer server(path, timed({}));
        ASSERT_EQ(driver.open(why), DeviceStage::opening);
        driver.close();
    }
    BridgeServer server(path, timed({.name = "a stronger one"}));
    EXPECT_EQ(driver.open(why), DeviceStage::failed);
    EXPECT_EQ(why, "another device answers: a stronger one");
    EXPECT_STREQ(driver.profile().name, "emulated Touch");
}

// A bridge process. It is killed at the end of its scope.
class Process {
  public:
    explicit Process(std::vector<std::string> arguments) {
        std::vector<char*> argv;
        for (std::string& argument : arguments)
            argv.push_back(argument.data());
        argv.push_back(nullptr);
        if (posix_spawn(&id_, argv[0], nullptr, nullptr, argv.data(), environ) != 0) id_ = -1;
    }
    ~Process() { end(SIGKILL); }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    void signal(int number) const { ::kill(id_, number); }
    int end(int number) {
        int status = 0;
        if (id_ > 0) {
            ::kill(id_, number);
            ::waitpid(id_, &status, 0);
        }
        id_ = -1;
        return status;
    }
    bool running() const { return ::kill(id_, 0) == 0; }

  private:
    pid_t id_ = -1;
};

PolledSettings impatient() {
    PolledSettings settings;
    settings.absent_retry_ns = 5 * kMs;
    settings.backoff_first_ns = 20 * kMs;
    settings.backoff_max_ns = 80 * kMs;
    return settings;
}

// stylet-bridge-emulator kills itself in the middle of a frame. It shares the driver's clock, and the
// test's thread polls the device, so ticks and exchanges are counted independently of the machine's load.
class KilledBridgeTest : public testing::Test {
  protected:
    std::unique_ptr<PolledDevice> make() {
        return std::make_unique<PolledDevice>(
            std::make_unique<BridgeDriver>(time.clock(), BridgeSettings{.socket_path = path}), time.clock(),
            impatient());
    }
    // Polls the device in place of its thread. Sleeps while the bridge process starts, because the clock must
    // not advance meanwhile.
    void poll(PolledDevice& device) {
        device.poll();
        if (device.stage() == DeviceStage::absent) test::sleepMs(1);
    }

    test::TempFolder folder;
    std::string path = folder / "bridge.sock";
    SteppedClock time;
};

// HZ-FORCE-14
TEST_F(KilledBridgeTest, BridgeKilledMidFrameEndsInZeroForceWithin20Ms) {
    for (const char* answers : {"20", "60"}) {
        const auto device = make();
        Process bridge({STYLET_BRIDGE_EMULATOR, path, answers, "0"});
        bool was_ready = false;
        std::int64_t fresh_ns = 0, lost_ns = 0, alive_wall_ns = 0;
        ASSERT_TRUE(test::waitUntil([&] {
            for (int i = 0; i < 100 && lost_ns == 0; ++i) {
                time.now_ns += kMs;
                const DeviceState state = device->read(time.now_ns);
                const bool ready = state.flags & kDeviceReady;
                if (ready && state.fresh != 0) fresh_ns = time.now_ns;
                if (was_ready && !ready) lost_ns = time.now_ns;
                was_ready = ready;
                device->send({0.0, 0.0, ready ? 1.0 : 0.0});
                if (ready) alive_wall_ns = test::monotonicNow_ns();
                if (lost_ns == 0) poll(*device);
            }
            return lost_ns != 0;
        })) << device->report().why;
        EXPECT_LE(lost_ns - fresh_ns, 20 * kMs);
        RecordProperty(std::string("wall_us_after_") + answers,
                       int((test::monotonicNow_ns() - alive_wall_ns) / 1000));
        EXPECT_TRUE(device->report().why.starts_with("the bridge is gone")) << device->report().why;
        EXPECT_EQ(device->report().failures, 1u);
        EXPECT_NE(bridge.end(0), 0);  // it killed itself
    }
}

// Clock of a loop on the test's thread. `between` is called between two ticks, in place of the device's
// thread.
struct LoopWorld {
    SteppedClock& time;
    std::function<void()> between;
    Clock clock() {
        return {this, [](void* w) noexcept { return static_cast<LoopWorld*>(w)->time.now_ns.load(); },
                [](void* w, std::int64_t t_ns) noexcept {
                    auto& world = *static_cast<LoopWorld*>(w);
                    world.time.advanceTo(t_ns);
                    world.between();
                }};
    }
};

// The test above with the needle in tissue and the haptic loop running. The force must be zero 20 ticks after
// the device's last answer, with a named fault.
// HZ-FORCE-07
TEST_F(KilledBridgeTest, BridgeKilledUnderLoadEndsInZeroForceWithin20Ticks) {
    using enum Tissue;
    const patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.060}}, 0.001);
    const patient::Patient patient(package);
    // The needle moves along the device's z axis and the patient's x axis. It starts 5 mm outside the
    // patient.
    constexpr double kLoad_n = 0.05;  // the model's 0.7 N, scaled to a tenth on such a weak device
    SimulationSettings settings;
    settings.patient_from_device.rotation = {0.70710678118654752, 0.0, -0.70710678118654752, 0.0};
    settings.patient_from_device.position_m = {0.095, 0.0, 0.0};
    const auto device = make();
    Process bridge({STYLET_BRIDGE_EMULATOR, path, "2600", "0.030"});
    settings.profile = device->profile();

    Simulation simulation(patient, settings);
    LoopChannels channels;
    double before_n = 0.0;
    int last_fresh = 0, last_pushed = 0, zero = 0, tick = 0;
    std::uint32_t faults = 0;
    const auto see = [&](const TickRecord& record) {
        ++tick;
        const double sent_n = glm::length(record.output.sent_device_n);
        if (sent_n > 0.0) last_pushed = tick;
        const bool ready = record.input.device.flags & kDeviceReady;
        faults = record.output.faults;
        if (ready) before_n = std::max(before_n, sent_n);
        if (ready && record.input.device.fresh != 0) last_fresh = tick;
        const bool loaded = before_n > kLoad_n;
        // The silence ends the force. The device may be reported as lost later.
        if (loaded && !ready && sent_n == 0.0) zero = last_pushed + 1;
        // The bridge starts after the loop. The loop therefore starts with a fault for the missing device.
        if (!loaded && faults != 0 && ready) channels.commands.push({CommandKind::rearm, 0});
    };
    LoopWorld world{time, [&] {
                        TickRecord record;
                        while (zero == 0 && channels.records.pop(record))
                            see(record);
                        if (zero != 0 || tick > 60'000) channels.stop.store(true);
                        poll(*device);
                    }};
    runLoop(simulation, *device, channels, world.clock());
    EXPECT_NE(bridge.end(0), 0);  // it killed itself
    ASSERT_NE(zero, 0) << device->report().why;
    EXPECT_LE(zero - last_fresh, 20);
    RecordProperty("ticks_to_zero", zero - last_fresh);
    EXPECT_NE(faults & (kFaultDeviceLost | kFaultStaleInput), 0u);
}

// A bridge in a separate process, on the machine's clock. serve() and the driver share that clock.
class BridgeProcessTest : public testing::Test {
  protected:
    void SetUp() override { state.flags = 0; }
    std::unique_ptr<PolledDevice> start() {
        auto device = std::make_unique<PolledDevice>(
            std::make_unique<BridgeDriver>(test::kWallClock, BridgeSettings{.socket_path = path}),
            test::kWallClock, impatient());
        device->start();
        return device;
    }
    // Ticks until `what` returns true. Returns false after a minute.
    bool tickUntil(PolledDevice& device, const std::function<bool()>& what) {
        return test::waitUntil([&] {
            state = device.read(test::monotonicNow_ns());
            if (what()) return true;
            device.send({0.0, 0.0, isReady() ? 1.0 : 0.0});
            return false;
        });
    }
    bool isReady() const { return state.flags & kDeviceReady; }

    test::TempFolder folder;
    std::string path = folder / "bridge.sock";
    DeviceState state;
};

// Real time: the device's own thread reconnects to a bridge that was killed and restarted.
TEST_F(BridgeProcessTest, ReconnectsAfterBackOffWhenTheBridgeReturns) {
    const auto device = start();
    auto bridge =
        std::make_unique<Process>(std::vector<std::string>{STYLET_BRIDGE_SIMULATED, "--socket", path});
    ASSERT_TRUE(tickUntil(*device, [&] { return isReady(); })) << device->report().why;
    EXPECT_STREQ(device->profile().name, "simulated Touch");
    for (int i = 0; i < 2; ++i) {
        bridge->end(SIGKILL);
        ASSERT_TRUE(tickUntil(*device, [&] { return !isReady(); }));
        // While the bridge is gone, the device tries to reconnect, but not more than once per 5 ms.
        const std::int64_t from_ns = test::monotonicNow_ns();
        const std::uint64_t opens = device->report().opens;
        ASSERT_TRUE(tickUntil(*device, [&] { return device->report().opens > opens + 4; }));
        const std::uint64_t more = device->report().opens - opens;
        EXPECT_LE(more, std::uint64_t((test::monotonicNow_ns() - from_ns) / (5 * kMs)) + 1);
        bridge =
            std::make_unique<Process>(std::vector<std::string>{STYLET_BRIDGE_SIMULATED, "--socket", path});
        ASSERT_TRUE(tickUntil(*device, [&] { return isReady(); })) << device->report().why;
    }
    EXPECT_EQ(bridge->end(SIGTERM), 0);
    EXPECT_FALSE(std::filesystem::exists(path));
}

// Real time: a stopped process keeps its socket open but sends nothing.
TEST_F(BridgeProcessTest, ReconnectsWhenASuspendedBridgeContinues) {
    Process bridge({STYLET_BRIDGE_SIMULATED, "--socket", path});
    const auto device = start();
    const std::string silent = "nothing from the bridge for 15 ms";
    std::string why;
    // Repeat if a stall of the test machine hid the reason. The device soon opens again.
    for (int tries = 0; tries < 20 && why != silent; ++tries) {
        ASSERT_TRUE(tickUntil(*device, [&] { return isReady(); })) << device->report().why;
        bridge.signal(SIGSTOP);
        why.clear();
        ASSERT_TRUE(tickUntil(*device, [&] {
            const DeviceReport report = device->report();
            if (report.stage == DeviceStage::failed && why.empty()) why = report.why;
            return !isReady() && !why.empty();
        }));
        bridge.signal(SIGCONT);
    }
    EXPECT_EQ(why, silent);
    EXPECT_TRUE(tickUntil(*device, [&] { return isReady(); })) << device->report().why;
}

}  // namespace
}  // namespace stylet::haptics
