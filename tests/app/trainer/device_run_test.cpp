// `stylet devices` and `stylet run --device`, as a user calls them, with emulated devices plugged in.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/haptics/devices/wooden_json.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/spacemouse_emulator.h"
#include "tests/support/woodenhaptics_emulator.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::Outcome;
using test::SpaceMouseEmulator;
using test::WoodenHapticsEmulator;

const std::string kRun = "run --headless --fps 0 --spacing-mm 2.5 --scenario ";

// A second thread for as long as it is in scope.
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

void nap(int ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

// The attempt whose output is there has begun: its record holds some ticks.
bool hasTicked(const std::filesystem::path& out) {
    std::error_code none;
    const auto bytes = std::filesystem::file_size(out / "record" / "inputs.bin", none);
    return !none && bytes > 1000;
}

class DeviceRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command;
        std::ofstream(*command_ / "arm.json") << test::woodenJson();
    }
    static void TearDownTestSuite() { delete command_; }
    void SetUp() override {
        if (!test::underUmockdev()) GTEST_SKIP() << "not run under umockdev";
    }
    static std::string run(const std::string& rest) {
        return kRun + "'" + test::testScenario("short").string() + "' " + rest;
    }
    static std::string output(const std::string& arguments) {
        const std::filesystem::path file = *command_ / "list";
        const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet' " + arguments +
                                 " >'" + file.string() + "'";
        EXPECT_EQ(std::system(line.c_str()), 0) << line;
        return test::textOf(file);
    }
    static inline Command* command_ = nullptr;
};

TEST_F(DeviceRun, DevicesAreListedForPeopleAndPrograms) {
    const SpaceMouseEmulator cap(SpaceMouseEmulator::Age::old);
    const std::string text = output("devices");
    EXPECT_NE(text.find("  " + cap.path() + ": SpaceNavigator (046d:c626): can be used\n"), std::string::npos)
        << text;
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

TEST_F(DeviceRun, ASpaceMouseMovesTheNeedleAndTheRecordReplays) {
    const std::filesystem::path out = *command_ / "spacemouse";
    SpaceMouseEmulator cap(SpaceMouseEmulator::Age::recent);
    Outcome live;
    {
        const Meanwhile hand([&](const std::atomic<bool>& over) {
            while (!over.load()) {
                cap.push({0, hasTicked(out) ? -350 : 0, 0, 0, 0, 0});
                nap(8);
            }
        });
        live = command_->runInto(out, run("--device spacemouse --seconds 2"));
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("stylet: spacemouse: ready"), std::string::npos) << live.err;
    EXPECT_EQ(live.summary.at("device"), "spacemouse");
    EXPECT_GE(live.summary.at("haptics").at("ticks").get<double>(), 2000.0);

    const std::filesystem::path record = out / "record", csv = *command_ / "hand.csv";
    const Outcome again =
        command_->run("replay '" + record.string() + "' --fast --save-hand '" + csv.string() + "'");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));

    // Pushed away from the user, the needle goes in.
    EXPECT_FALSE(live.summary.at("punctures").empty());
    std::ifstream lines(csv);
    std::string line, first, last;
    std::getline(lines, line);
    EXPECT_EQ(line, "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons");
    while (std::getline(lines, line)) {
        if (first.empty()) first = line;
        last = line;
    }
    double from[3], to[3];
    ASSERT_EQ(std::sscanf(first.c_str(), "%*[^,],%lf,%lf,%lf", &from[0], &from[1], &from[2]), 3);
    ASSERT_EQ(std::sscanf(last.c_str(), "%*[^,],%lf,%lf,%lf", &to[0], &to[1], &to[2]), 3);
    EXPECT_GT(std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]), 0.02);

    const Outcome replayed = command_->run(run("--fast --device replay --trace '" + csv.string() + "'"));
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    EXPECT_EQ(replayed.summary.at("device"), "replay");
    EXPECT_NEAR(replayed.summary.at("haptics").at("ticks").get<double>(),
                live.summary.at("haptics").at("ticks").get<double>(), 50.0);
}

TEST_F(DeviceRun, AWoodenHapticsIsWaitedForUntilItIsHomed) {
    WoodenHapticsEmulator board;
    Outcome live;
    {
        const Meanwhile user([&](const std::atomic<bool>& over) {
            while (!over.load() && board.seen().commands < 20)
                nap(10);
            board.pressButton();
        });
        live = command_->run(run("--seconds 1 --device woodenhaptics --device-model '" +
                                 (*command_ / "arm.json").string() + "'"));
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("needs homing: park the arm"), std::string::npos) << live.err;
    EXPECT_NE(live.err.find("woodenhaptics: ready"), std::string::npos) << live.err;
    EXPECT_EQ(live.summary.at("device"), "woodenhaptics");
    for (int i = 0; i < 200 && board.seen().motor_ma != std::array<int, 3>{}; ++i)
        nap(50);
    EXPECT_EQ(board.seen().motor_ma, (std::array<int, 3>{})) << "zero is the last it was told";
}

// A device that does not say how far it reaches and whose origin is far from the hand: the path is where the
// hand is. The hand goes out of the body (+z, to the patient's right), comes back and punctures the skin.
TEST_F(DeviceRun, ThePathIsWhereTheHandIsWhenTheReachIsUnknown) {
    const std::string socket = (*command_ / "bridge.sock").string();
    const test::BridgeServer bridge(socket, {.position_m = {0.5, -0.4, 0.6},
                                             .stroke_m = -0.2,
                                             .period_s = 4.0,
                                             .workspace_radius_m = std::nan("")});
    const Outcome live = command_->run(run("--device bridge --socket '" + socket + "' --seconds 5"));
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("stylet: bridge: ready"), std::string::npos) << live.err;
    EXPECT_EQ(live.summary.at("device"), "bridge");
    EXPECT_FALSE(live.summary.at("punctures").empty());
    EXPECT_EQ(bridge.motor_n(), 0.0);
}

TEST_F(DeviceRun, UnpluggedMidRunItIsAFaultWithAName) {
    const std::filesystem::path out = *command_ / "unplugged";
    Outcome live;
    {
        SpaceMouseEmulator cap(SpaceMouseEmulator::Age::recent);
        const Meanwhile hand([&](const std::atomic<bool>& over) {
            cap.push({0, 0, 0, 0, 0, 0});
            while (!over.load() && !hasTicked(out))
                nap(10);
            nap(300);
            cap.unplug();
        });
        live = command_->runInto(out, run("--device spacemouse --seconds 3"));
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("/dev/hidraw"), std::string::npos) << live.err;
    EXPECT_NE(live.summary.at("haptics").at("faults"), 0);
}

TEST_F(DeviceRun, WhatDoesNotGoTogetherIsRefusedBeforeAnythingIsMade) {
    Command command;
    const auto expectRefused = [&](const std::string& arguments, const std::string& words) {
        const Outcome outcome = command.run(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(command.out()));
    };
    expectRefused("run --device joystick", "not among: ");
    expectRefused("run --device woodenhaptics", "--device-model");
    expectRefused("run --device spacemouse --fast", "real time");
    expectRefused("run --device replay", "--trace");
    expectRefused("run --trace hand.csv", "--trace");
    expectRefused("run --seconds 3", "--seconds");
}

}  // namespace
}  // namespace stylet::trainer
