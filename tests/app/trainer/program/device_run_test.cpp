// Runs `stylet devices` and `stylet run --device` as a user does, with emulated devices.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <thread>

#include "app/records/replay.h"
#include "app/records/samples.h"
#include "base/hex.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/haptics/devices/wooden_json.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/inverse3_emulator.h"
#include "tests/support/program_output.h"
#include "tests/support/spacemouse_emulator.h"
#include "tests/support/wait_until.h"
#include "tests/support/woodenhaptics_emulator.h"
#ifdef STYLET_TEST_WINDOW
#include "tests/support/x_display.h"
#endif

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::Outcome;
using test::sleepMs;
using test::SpaceMouseEmulator;
using test::WoodenHapticsEmulator;
using testing::HasSubstr;

const std::string kDeviceRun = "run --headless --fps 0 --spacing-mm 2.5 --scenario ";

// Runs a function in a second thread during its own lifetime.
class Meanwhile {
  public:
    explicit Meanwhile(const std::function<void(const std::atomic<bool>&)>& body)
        : thread_([this, body] { body(over_); }) {}
    ~Meanwhile() {
        over_.store(true);
        thread_.join();
    }

  private:
    std::atomic<bool> over_{false};
    std::thread thread_;
};

// Depth of the needle in the newest stored sample of the attempt that writes into `out`; 0 before the first.
double storedDepth_m(const std::filesystem::path& out) {
    if (!std::filesystem::exists(out / "record" / "samples.bin")) return 0.0;
    const std::vector<records::Sample> samples = records::loadSamples(out / "record").samples;
    return samples.empty() ? 0.0 : samples.back().depth_m;
}

// Pushes the cap away from the user until the needle is in the body. At half of its deflection the tool moves
// at 18 mm/s, so that a tick that is 50 ms late is no leap. A longer stall can still carry the tool into the
// body, where it gives no force: after four seconds the cap is pulled, and then pushed again.
void pushIn(SpaceMouseEmulator& cap, const std::filesystem::path& out, const std::atomic<bool>& over) {
    constexpr int kPushesPerLook = 25, kPushesPerStroke = 500;
    for (int n = 1; !over.load(); ++n, sleepMs(8)) {
        const bool inward = n / kPushesPerStroke % 2 == 0;
        cap.push({0, inward ? -180 : 180, 0, 0, 0, 0});
        if (n % kPushesPerLook == 0 && storedDepth_m(out) > 0.015) return;
    }
}

// Returns true once the attempt that writes into `out` has recorded some ticks.
bool hasTicked(const std::filesystem::path& out) {
    std::error_code none;
    const auto bytes = std::filesystem::file_size(out / "record" / "inputs.bin", none);
    return !none && bytes > 1000;
}

class DeviceRun : public testing::Test {
  protected:
    // Sends Ctrl-C.
    static void interrupt() { test::signalProgram(*command_ / "number"); }
    static void SetUpTestSuite() {
        command_ = new Command;
        std::ofstream(*command_ / "arm.json") << test::woodenJson();
    }
    static void TearDownTestSuite() { delete command_; }
    void SetUp() override {
        if (!test::underUmockdev()) GTEST_SKIP() << "not run under umockdev";
    }
    static std::string run(const std::string& rest) {
        return kDeviceRun + "'" + test::testScenario("short").string() + "' " + rest;
    }
    static std::string output(const std::string& arguments) {
        const std::filesystem::path file = *command_ / "list";
        const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet' " + arguments +
                                 " >'" + file.string() + "'";
        EXPECT_EQ(std::system(line.c_str()), 0) << line;
        return test::readText(file);
    }
    static inline Command* command_ = nullptr;
};

// Need real time: the whole program drives an emulated device at its real rate. The last force that is sent
// must be zero.
using DeviceRunRealTime = DeviceRun;

TEST_F(DeviceRun, DevicesAreListedForPeopleAndPrograms) {
    const SpaceMouseEmulator cap(SpaceMouseEmulator::Age::old);
    const std::string text = output("devices");
    EXPECT_THAT(text, HasSubstr("  " + cap.path() + ": SpaceNavigator (046d:c626): can be used\n"));
    const json list = json::parse(output("devices --json")).at("devices");
    bool seen = false;
    for (const json& kind : list) {
        EXPECT_TRUE(kind.at("limits").is_object()) << kind;
        if (kind.at("name") != "spacemouse") continue;
        seen = true;
        EXPECT_EQ(kind.at("found").at(0).at("place"), cap.path());
        EXPECT_EQ(kind.at("found").at(0).at("problem"), "");
        EXPECT_EQ(kind.at("limits").at("force_axes"), 0);
        EXPECT_TRUE(kind.at("limits").at("resolution_m").is_null());
    }
    EXPECT_TRUE(seen);
}

// A user without headset and terminal: the cap moves the tool, and the window, if this build has one, has a
// key for every command.
TEST_F(DeviceRunRealTime, ASpaceMouseMovesTheNeedleAndTheRecordReplays) {
    const std::filesystem::path out = *command_ / "spacemouse", said = *command_ / "stderr";
    SpaceMouseEmulator cap(SpaceMouseEmulator::Age::recent);
    std::filesystem::remove(said);
    std::string never;  // the first expected text that was not printed
    std::string options = "--device spacemouse --seconds 240";
    using Press = std::function<void(const std::atomic<bool>&)>;
    Press pressKeys = [](const std::atomic<bool>&) {}, pressInject = pressKeys;
#ifdef STYLET_TEST_WINDOW
    const test::XDisplay display(1500, 950);
    command_->set("XR_RUNTIME_JSON", "/nonexistent.json");
    options =
        "run --mute --spacing-mm 2.5 --scenario '" + test::testScenario("short").string() + "' " + options;
    test::ProgramOutput output(said);
    const auto hears = [&](const std::string& words, const std::atomic<bool>& over) {
        for (int i = 0; i < 10000 && !over.load(); ++i, sleepMs(20))
            if (output.contains(words)) return true;
        never += (never.empty() ? "" : "; ") + words;
        return false;
    };
    using Answer = std::pair<const char*, const char*>;  // a key, and the text that it must give
    const auto press = [&](std::initializer_list<Answer> keys, const std::atomic<bool>& over) {
        for (const auto& [key, words] : keys) {
            display.key(key);
            if (!hears(words, over)) return;
        }
    };
    pressKeys = [&](const std::atomic<bool>& over) {
        if (!hears("using a window instead", over) || !hears("you control the ", over)) return;
        while (!over.load() && display.title().empty())
            sleepMs(20);
        press({{"h", "asked for a breath-hold"},
               {"b", "the patient may breathe"},
               {"x", "X-rays"},
               {"x", "no more X-rays"},
               {"i", "contrast medium needs a needle in the body"}},
              over);
    };
    pressInject = [&](const std::atomic<bool>& over) {
        press({{"i", "contrast medium, 1 ml/s"}, {"i", "no more contrast medium"}}, over);
    };
#else
    options = run(options);
#endif
    Outcome live;
    {
        const Meanwhile hand([&](const std::atomic<bool>& over) {
            while (!over.load() && !hasTicked(out))
                sleepMs(8);
            pressKeys(over);
            pushIn(cap, out, over);
            pressInject(over);
            interrupt();
        });
        live = command_->runInto(out, options, *command_ / "number");
    }
    command_->unset("XR_RUNTIME_JSON");
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_EQ(never, "") << live.err;
    EXPECT_THAT(live.err, HasSubstr("stylet: spacemouse: ready"));
    EXPECT_EQ(live.summary.at("device"), "spacemouse");
#ifdef STYLET_TEST_WINDOW
    EXPECT_GT(live.summary.at("dose").at("pulses").get<int>(), 0);
    EXPECT_GT(live.summary.at("dose").at("contrast_ml").get<double>(), 0.0);
#endif

    const std::filesystem::path record = out / "record", csv = *command_ / "hand.csv";
    const Outcome again =
        command_->run("replay '" + record.string() + "' --fast --save-hand '" + csv.string() + "'");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));

    EXPECT_FALSE(live.summary.at("punctures").empty()) << "pushed away from the user, the needle goes in";
    std::ifstream lines(csv);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons");
    std::optional<Vec3> from_m;
    double furthest_m = 0.0;
    while (std::getline(lines, line)) {
        Vec3 at_m;
        ASSERT_EQ(std::sscanf(line.c_str(), "%*[^,],%lf,%lf,%lf", &at_m.x, &at_m.y, &at_m.z), 3) << line;
        if (!from_m) from_m = at_m;
        furthest_m = std::max(furthest_m, glm::distance(*from_m, at_m));
    }
    EXPECT_GT(furthest_m, 0.015);  // the depth that ends pushIn(), which may then be pulling back

    const Outcome replayed = command_->run(run("--fast --device replay --trace '" + csv.string() + "'"));
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    EXPECT_EQ(replayed.summary.at("device"), "replay");
    EXPECT_NEAR(replayed.summary.at("haptics").at("ticks").get<double>(),
                live.summary.at("haptics").at("ticks").get<double>(), 50.0);
}

TEST_F(DeviceRunRealTime, AWoodenHapticsIsWaitedForUntilItIsHomed) {
    WoodenHapticsEmulator board;
    const std::filesystem::path told = *command_ / "stderr";
    std::filesystem::remove(told);
    Outcome live;
    {
        // Presses the button when the program asks for homing. Presses again if the program lost the board
        // because of a stall.
        const Meanwhile user([&](const std::atomic<bool>& over) {
            while (!over.load()) {
                const std::string said = test::readText(told);
                const std::size_t asked = said.rfind("needs homing"), ready = said.rfind("ready");
                if (asked != std::string::npos && (ready == std::string::npos || ready < asked)) {
                    board.pressButton();
                    for (int i = 0; i < 50 && !over.load(); ++i)
                        sleepMs(10);
                }
                sleepMs(10);
            }
        });
        live = command_->run(run("--seconds 1 --device woodenhaptics --device-model '" +
                                 (*command_ / "arm.json").string() + "'"));
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_THAT(live.err, HasSubstr("needs homing: park the arm"));
    EXPECT_THAT(live.err, HasSubstr("woodenhaptics: ready"));
    EXPECT_EQ(live.summary.at("device"), "woodenhaptics");
    EXPECT_GE(live.summary.at("haptics").at("ticks").get<double>(), 1000.0);
    EXPECT_TRUE(test::waitUntil([&] { return board.commandLog().motor_ma == std::array<int, 3>{}; }))
        << "the last force sent must be zero";
}

// Sends commands through a pipe that is the program's stdin.
class Words {
  public:
    explicit Words(std::filesystem::path pipe) : pipe_(std::move(pipe)) {
        ::mkfifo(pipe_.c_str(), 0600);
        ::signal(SIGPIPE, SIG_IGN);  // the program may end before the user
    }
    ~Words() {
        if (end_ >= 0) ::close(end_);
    }
    Words(const Words&) = delete;
    Words& operator=(const Words&) = delete;
    // Blocks until the program has opened the pipe.
    void begin() { end_ = ::open(pipe_.c_str(), O_WRONLY | O_CLOEXEC); }
    void say(const std::string& word) {
        const std::string line = word + "\n";
        EXPECT_EQ(::write(end_, line.c_str(), line.size()), ssize_t(line.size()));
        sleepMs(60);
    }

  private:
    std::filesystem::path pipe_;
    int end_ = -1;
};

// A user of the emulated bridge, who types commands and moves along the path. The path's entry is at out = 0.
// Positive values are outside the body.
class DeviceUser {
  public:
    DeviceUser(test::BridgeServer& bridge, std::filesystem::path pipe, std::filesystem::path record,
               const std::filesystem::path& told)
        : bridge_(bridge), words_(std::move(pipe)), record_(std::move(record)), output_(told) {
        std::filesystem::remove(told);
    }
    // Waits until the attempt runs.
    void begin() {
        words_.begin();
        while (!over() && !hasTicked(record_.parent_path()))
            sleepMs(10);
    }
    void say(const std::string& word) { words_.say(word); }
    // Repeats `act` until the program prints `words`, because a program short of CPU time can miss a button
    // press.
    void until(const std::string& words, const std::function<void()>& act) {
        while (!over()) {
            act();
            if (output_.waitFor(words, std::chrono::seconds(2))) return;
        }
    }
    void press(std::uint32_t button) {
        bridge_.hold(out_m_, button);
        stay();
        bridge_.hold(out_m_);
        stay();
    }
    // Moves at about 60 mm/s, so that even a stall of 15 ms causes no over-speed fault.
    void move(double to_mm) {
        const double step_m = to_mm * 1e-3 > out_m_ ? 0.0002 : -0.0002;
        while (!over() && std::fabs(out_m_ - to_mm * 1e-3) > 0.00015) {
            bridge_.hold(out_m_ += step_m);
            sleepMs(3);
        }
        stay();
    }
    bool over() const { return over_.load(); }
    void end() { over_.store(true); }

  private:
    // Waits 60 ms, and then until the device has answered 50 more requests, but at most about 5 s.
    void stay() const {
        const std::uint64_t from = bridge_.answered();
        sleepMs(60);
        for (int i = 0; i < 500 && bridge_.answered() < from + 50; ++i)
            sleepMs(10);
    }

    test::BridgeServer& bridge_;
    Words words_;
    std::filesystem::path record_;
    test::ProgramOutput output_;
    double out_m_ = 0.008;
    std::atomic<bool> over_{false};
};

// The user changes between five tools on one device, by commands and by buttons. The record contains the
// changes.
TEST_F(DeviceRunRealTime, EveryToolIsSelectedByCommandOrButton) {
    const std::string socket = (*command_ / "tools.sock").string();
    const std::filesystem::path out = *command_ / "tools", pipe = *command_ / "words";
    // Places the path as haptics/devices/clutch.h does: 11 mm in front of the soft wall. The wall's thickness
    // is a tenth of the radius.
    test::BridgeServer bridge(socket,
                              {.position_m = {0.0, 0.0, 0.1 + 0.09 - 0.011}, .workspace_radius_m = 0.1});
    bridge.hold(0.008);
    DeviceUser user(bridge, pipe, out / "record", *command_ / "stderr");
    constexpr double kClear_mm = 20.0;  // outside the body with every tool
    std::atomic<double> ended_n{0.0};
    Outcome live;
    {
        const Meanwhile hand([&](const std::atomic<bool>&) {
            user.begin();
            user.until("the finger is in hand", [&] { user.say("finger"); });
            user.move(-6);
            user.move(kClear_mm);
            user.until("the probe is in hand", [&] { user.press(2); });
            // Parks the probe. After a long stall the probe cannot be parked until it has left the skin once.
            user.until("the scalpel is in hand", [&] {
                user.move(kClear_mm);
                user.move(-4);
                user.press(2);
            });
            user.move(kClear_mm);
            user.until("the probe is lifted off", [&] { user.say("lift"); });
            user.until("asked for a breath-hold", [&] { user.say("hold"); });
            user.until("the guide is in hand", [&] { user.press(2); });
            user.until("the needle stays in hand", [&] {
                user.move(10);
                user.say("needle");
                user.say("rearm");
                user.move(-25);
                user.say("finger");
            });
            user.until("the patient may breathe", [&] { user.press(4); });
            user.say("scissors");
            // Breathing sometimes brings the force to zero, a stall of the machine can switch it off, and
            // after a longer one the device has left the needle: the user draws it out and inserts it again.
            // Repeat until the last force is above the limit.
            for (int i = 0; i < 10'000 && !user.over() && ended_n <= 0.02; ++i) {
                if (i % 100 == 99) {
                    if (i % 300 == 299) {
                        user.move(10);
                        sleepMs(700);  // drawn out after haptics::kDrawnOut_s outside the body
                    }
                    user.say("rearm");
                    user.move(i % 200 == 99 ? -24 : -25);
                }
                sleepMs(10);
                ended_n = bridge.commanded_n();
            }
            interrupt();
        });
        live = command_->runInto(
            out, run("--device bridge --seconds 240 --socket '" + socket + "' <'" + pipe.string() + "'"),
            *command_ / "number");
        user.end();
    }
    ASSERT_EQ(live.status, 0) << live.err;
    std::size_t at = 0;
    for (const char* words :
         {"bridge: ready", "you control the needle", "button 2 selects the next tool",
          "the finger is in hand", "the probe is in hand", "the probe stays where it is",
          "the scalpel is in hand", "the probe is lifted off", "asked for a breath-hold",
          "the guide is in hand", "the needle is in hand", "the needle stays in hand: it is in the body",
          "the patient may breathe", "\"scissors\" is not a command"}) {
        const std::size_t found = live.err.find(words, at);
        ASSERT_NE(found, std::string::npos) << words << " is missing, or out of order, in:\n" << live.err;
        at = found;
    }
    EXPECT_EQ(live.summary.at("device"), "bridge");
    EXPECT_GT(ended_n.load(), 0.02) << "the run must end while the needle is felt. Output:\n" << live.err;
    EXPECT_TRUE(test::waitUntil([&] { return bridge.commanded_n() == 0.0; }))
        << "the last force sent must be zero";

    const records::Record record = records::loadRecord(out / "record");
    const patient::Package package = patient::loadPackage(record.info.patient_folder);
    const patient::Patient patient(package);
    std::map<haptics::Tool, double> felt_n;
    const records::ReplayResult again = records::replay(
        patient, record,
        [&](const haptics::TickInput&, const haptics::TickOutput& now, const haptics::NeedleEvents&) {
            felt_n[now.tool] = std::max(felt_n[now.tool], glm::length(now.tool_force.force_n));
        });
    EXPECT_TRUE(again.equal());
    EXPECT_EQ(hexText(again.state_hash), live.summary.at("state_hash").get<std::string>());
    for (const haptics::Tool tool : {haptics::Tool::finger, haptics::Tool::probe, haptics::Tool::needle})
        EXPECT_GT(felt_n[tool], 0.05) << haptics::kToolNames[std::size_t(tool)];
}

// Uses the emulated Haply service. The device is listed with its port, and the user moves it. It reports no
// workspace, and its hand is far from its origin, so the middle of the path is at the hand. The last force
// that is sent is zero.
TEST_F(DeviceRunRealTime, AnInverse3IsListedAndPunctures) {
    test::Inverse3Emulator service({.cursor_m = {0.2, -0.4, 0.3}});
    const std::string port = " --port " + std::to_string(service.port());
    const json list = json::parse(output("devices --json" + port)).at("devices");
    const auto kind =
        std::find_if(list.begin(), list.end(), [](const json& k) { return k.at("name") == "inverse3"; });
    ASSERT_NE(kind, list.end());
    if (!kind->at("built")) GTEST_SKIP() << "this build has no Boost";
    ASSERT_EQ(kind->at("found").size(), 1u);
    EXPECT_EQ(kind->at("found").at(0).at("place"), "localhost:" + std::to_string(service.port()));
    EXPECT_EQ(kind->at("found").at(0).at("problem"), "");
    EXPECT_THAT(output("devices" + port), HasSubstr("inverse3: Haply Inverse3"));

    const std::filesystem::path out = *command_ / "inverse3", pipe = *command_ / "inverse3-words";
    Words words(pipe);
    std::atomic<double> most_n{0.0};
    Outcome live;
    {
        const Meanwhile hand([&](const std::atomic<bool>& over) {
            words.begin();
            while (!over.load() && !std::filesystem::exists(out / "record"))
                sleepMs(10);
            // The middle of the path is at the hand. The tool moves out of the body and in again while the
            // force ramps up. Repeat this if a stall switched the force off.
            double out_m = 0.0;
            const auto move = [&](double to_m) {
                while (!over.load() && std::fabs(out_m - to_m) > 5e-4) {
                    service.hold(out_m += to_m > out_m ? 5e-4 : -5e-4);
                    sleepMs(2);
                    const auto force_n = service.force_n();
                    most_n.store(std::max(most_n.load(), std::hypot(force_n[0], force_n[1], force_n[2])));
                }
            };
            do {
                move(0.08);
                words.say("rearm");
                sleepMs(200);
                move(0.0);
            } while (!over.load() && most_n <= 0.05);
            move(0.08);
            interrupt();
        });
        live = command_->runInto(out,
                                 run("--device inverse3 --seconds 240" + port + " <'" + pipe.string() + "'"),
                                 *command_ / "number");
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_EQ(live.summary.at("device"), "inverse3");
    EXPECT_FALSE(live.summary.at("punctures").empty()) << live.err;
    EXPECT_GT(most_n.load(), 0.05) << live.err;
    EXPECT_TRUE(test::waitUntil([&] { return service.force_n() == std::array<double, 3>{}; }));
    EXPECT_EQ(service.complaint(), "");
    const Outcome again = command_->run("replay '" + out.string() + "' --fast");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));
}

TEST_F(DeviceRun, ABridgeIsListedWhileItListens) {
    const std::string socket = (*command_ / "listed.sock").string();
    {
        const test::BridgeServer bridge(socket, {});
        EXPECT_THAT(output("devices --socket '" + socket + "'"),
                    HasSubstr(socket + ": a bridge's socket: can be used"));
    }
    EXPECT_THAT(output("devices --socket '" + socket + "'"), HasSubstr("no program listens"));
}

// The console reports the newest state: a program that was stalled may skip the read error and find no
// device.
bool isLossReported(const std::string& output) {
    const std::size_t ready = output.find("spacemouse: ready");
    if (ready == std::string::npos) return false;
    return output.find("/dev/hidraw", ready) != std::string::npos ||
           output.find("no SpaceMouse is plugged in", ready) != std::string::npos;
}

// HZ-FORCE-07
TEST_F(DeviceRunRealTime, UnpluggedDeviceIsANamedFault) {
    const std::filesystem::path out = *command_ / "unplugged", told = *command_ / "stderr";
    std::filesystem::remove(told);
    Outcome live;
    {
        SpaceMouseEmulator cap(SpaceMouseEmulator::Age::recent);
        const Meanwhile hand([&](const std::atomic<bool>& over) {
            cap.push({0, 0, 0, 0, 0, 0});
            while (!over.load() && !hasTicked(out))
                sleepMs(10);
            cap.unplug();
            while (!over.load() && !isLossReported(test::readText(told)))
                sleepMs(10);
            // The loop detects the loss in its next tick. Wait until more ticks are written.
            std::error_code none;
            const std::filesystem::path inputs = out / "record" / "inputs.bin";
            const auto bytes = std::filesystem::file_size(inputs, none);
            while (!over.load() && std::filesystem::file_size(inputs, none) == bytes)
                sleepMs(10);
            interrupt();
        });
        live = command_->runInto(out, run("--device spacemouse --seconds 240"), *command_ / "number");
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_TRUE(isLossReported(live.err)) << live.err;
    EXPECT_NE(live.summary.at("haptics").at("faults"), 0);
}

TEST_F(DeviceRun, ConflictingOptionsAreRefusedBeforeAnyOutput) {
    Command command;
    const auto expectRefused = [&](const std::string& arguments, const std::string& words, int status = 100) {
        const Outcome outcome = command.run(arguments);
        EXPECT_EQ(outcome.status, status) << arguments;
        EXPECT_THAT(outcome.err, HasSubstr(words));
        EXPECT_FALSE(std::filesystem::exists(command.out()));
    };
    expectRefused("run --device mouze", "not among: scripted, replay, controllers, mouse, falcon", 2);
    expectRefused("run --device mouze --fast", "not among: ", 2);
    expectRefused("run --device woodenhaptics", "--device-model", 2);
    expectRefused("run --device spacemouse --fast", "real time");
    expectRefused("run --device replay", "--trace");
    expectRefused("run --trace hand.csv", "--trace");
    expectRefused("run --seconds 3", "--seconds");
}

}  // namespace
}  // namespace stylet::trainer
