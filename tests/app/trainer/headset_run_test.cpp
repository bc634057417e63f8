// `stylet run` in real time on a runtime that takes the headset away, lets go of nobody, or is watched by a
// layer.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <regex>
#include <thread>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::Outcome;

// Four frames a second or so on a processor: small eyes.
const std::string kEyes = R"("version": 2, "eyes": {"recommended_size": [96, 96]},
    "head": [{"t_s": 0, "position": [0, 1.5, -0.1], "orientation": [-0.38268343, 0, 0, 0.92387953]}])";

class HeadsetRun : public testing::Test {
  protected:
    static Outcome run(const std::string& scenario, const std::string& rest = "") {
        std::ofstream(command_ / "scenario.json")
            << "{" << kEyes << (scenario.empty() ? "" : ", ") << scenario << "}";
        command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
        return command_.run("run --headless --spacing-mm 2.5 --scenario '" +
                            test::testScenario("short").string() + "' " + rest);
    }
    // The record, computed again, comes to the same.
    static void expectTheSameAgain(const Outcome& outcome) {
        const std::string record = (command_.out() / "record").string();
        command_.unset("XRMOCK_SCENARIO");
        const Outcome again = command_.run("replay '" + record + "' --fast");
        ASSERT_EQ(again.status, 0) << again.out << again.err;
        EXPECT_EQ(again.summary.at("state_hash"), outcome.summary.at("state_hash"));
    }
    // Of an attempt that nothing happens to.
    static double steadyTicks() {
        static const double ticks = ticksOf(run(""));
        return ticks;
    }
    static double ticksOf(const Outcome& outcome) {
        return outcome.summary.at("haptics").at("ticks").get<double>();
    }
    static inline Command command_;
    static constexpr double kEndTicks = 20;  // in which the session sees that the script is over
};

// Each headset is lost as soon as it has settled, the next one too: ticks, session and record never notice.
// HZ-RECORD-12
TEST_F(HeadsetRun, LosingTheHeadsetAgainAndAgainCostsTheAttemptNothing) {
    const double steady = steadyTicks();
    const Outcome outcome = run(R"("events": [{"t_s": 1.5, "session_loss": {"lost_after_s": 0}}])");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("the headset was lost"), std::string::npos) << outcome.err;
    EXPECT_GE(outcome.summary.at("headsets_found_again").get<int>(), 1);
    EXPECT_NEAR(ticksOf(outcome), steady, kEndTicks);
    expectTheSameAgain(outcome);
}

TEST_F(HeadsetRun, AnAttemptWaitsForWhoLooksAwayAndItsTimeStandsStill) {
    const double steady = steadyTicks();
    const auto begin = std::chrono::steady_clock::now();
    const Outcome outcome =
        run(R"("events": [{"t_s": 2.0, "session": "visible"}, {"t_s": 6.0, "session": "focused"}])");
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NEAR(ticksOf(outcome), steady, kEndTicks) << "no tick of the pause is in the record";
    EXPECT_GT(took.count(), 1e-3 * ticksOf(outcome) + 3.0);
    EXPECT_NE(outcome.err.find("another program has the focus"), std::string::npos) << outcome.err;
    expectTheSameAgain(outcome);
}

TEST_F(HeadsetRun, ARuntimeThatEndsTheSessionLeavesAScriptedAttemptItsEnd) {
    const Outcome outcome = run(R"("exit_after_frames": 6)");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("ended the session"), std::string::npos) << outcome.err;
    expectTheSameAgain(outcome);
}

// A line to the mock runtime's control socket, once it is there.
void tell(const std::string& path, const std::string& line, const std::atomic<bool>& over) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    while (!over.load()) {
        const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
        if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
            EXPECT_EQ(::write(fd, line.data(), line.size()), ssize_t(line.size()));
            while (!over.load())
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
            ::close(fd);
            return;
        }
        ::close(fd);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

TEST_F(HeadsetRun, ARuntimeThatNeverAnswersAgainKeepsNothing) {
    const std::string socket = (command_ / "control").string();
    command_.set("XRMOCK_CONTROL", socket);
    std::atomic<bool> over{false};
    std::thread pauser([&] { tell(socket, "{\"pause\": true}\n", over); });
    const Outcome outcome = run("");
    over.store(true);
    pauser.join();
    command_.unset("XRMOCK_CONTROL");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("does not let go of a frame; all is stored"), std::string::npos)
        << outcome.err;
    expectTheSameAgain(outcome);
}

// Debian's version of the layer (1.0.20) waits for its own lock when a moment is marked: the scenario
// captures.
TEST_F(HeadsetRun, TheValidationLayerOfOpenXrIsSilent) {
    std::string layers;
    for (const char* folder : {"/usr/share/openxr/1/api_layers/explicit.d"})
        if (std::filesystem::exists(folder))
            for (const auto& entry : std::filesystem::directory_iterator(folder))
                layers += entry.path().filename().string() + " ";
    if (layers.find("core_validation") == std::string::npos)
        GTEST_SKIP() << "openxr-layer-corevalidation is not installed";
    const std::filesystem::path scenario = command_ / "unmarked.toml";
    std::ofstream(scenario) << std::regex_replace(test::textOf(test::testScenario("short")),
                                                  std::regex("moments = \\[[^\\]]*\\]"), "moments = []");
    std::ofstream(command_ / "scenario.json") << "{" << kEyes << "}";
    command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
    command_.set("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation");
    command_.set("XR_CORE_VALIDATION_EXPORT_TYPE", "text");
    command_.set("XR_CORE_VALIDATION_FILE_NAME", (command_ / "validation.txt").string());
    const Outcome outcome =
        command_.run("run --headless --spacing-mm 2.5 --scenario '" + scenario.string() + "'");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_GT(outcome.summary.at("frames").get<int>(), 5);
    EXPECT_EQ(test::textOf(command_ / "validation.txt").find("VUID"), std::string::npos)
        << test::textOf(command_ / "validation.txt");
}

}  // namespace
}  // namespace stylet::trainer
