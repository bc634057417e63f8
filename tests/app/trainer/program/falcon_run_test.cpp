// Runs `stylet run --device falcon` and its calibration as a user does, with an emulated Falcon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <signal.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <thread>

#include "haptics/devices/falcon/falcon.h"
#include "haptics/devices/falcon/falcon_kinematics.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/support/falcon_testbed.h"
#include "tests/support/nap.h"

namespace stylet::trainer {
namespace {

using test::FalconEmulator;
using test::sleepMs;
using testing::HasSubstr;

// Homes the device repeatedly during its own lifetime.
class Hand {
  public:
    explicit Hand(test::FalconTestbed& bed)
        : thread_([this, &bed] {
              while (!over_.load()) {
                  bed.with([](FalconEmulator& f) { f.home(); });
                  std::this_thread::sleep_for(std::chrono::milliseconds(50));
              }
          }) {}
    ~Hand() {
        over_.store(true);
        thread_.join();
    }
    Hand(const Hand&) = delete;
    Hand& operator=(const Hand&) = delete;

  private:
    std::atomic<bool> over_{false};
    std::thread thread_;
};

// Moves the device during an attempt that writes to `out`. Waits until the record begins. Then moves along
// the path into the body while the force ramps up, stops there, and moves out again. On a busy machine the
// emulated device has faults, so each pass is short, starts by re-arming, and re-arms in the body too until a
// force was felt.
class Work {
  public:
    Work(test::FalconTestbed& bed, const std::filesystem::path& out)
        : bed_(&bed), out_(out), thread_([this] { run(); }) {}
    ~Work() {
        over_.store(true);
        thread_.join();
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;
    bool pushed() const { return pushed_.load(); }
    // Completed passes (into the body and out again) in which the motors produced a force.
    int passes() const { return passes_.load(); }

  private:
    void run() {
        hold(outside_m_);
        while (!over_.load() && !std::filesystem::exists(out_ / "record")) {
            bed_->with([](FalconEmulator& f) { f.home(); });
            sleepMs(20);
        }
        while (!over_.load()) {
            rearm();
            move(0.0, 0.030);
            stay(400);
            for (int tries = 0; tries < 3 && !pushed(); ++tries) {
                rearm();
                stay(400);
            }
            move(0.030, 0.0);
            if (pushed()) ++passes_;
        }
    }
    void rearm() {
        bed_->with([](FalconEmulator& f) { f.press(1); });
        stay(100);
        bed_->with([](FalconEmulator& f) { f.press(0); });
        stay(200);
    }
    // Moves between depths along the path at 50 mm/s, in steps that the driver does not reject as a jump.
    void move(double from_m, double to_m) {
        constexpr int kSteps = 120;
        for (int i = 1; i <= kSteps && !over_.load(); ++i) {
            hold(outside_m_ - from_m - (to_m - from_m) * i / kSteps);
            stay(5);
        }
    }
    void stay(int ms) {
        for (int passed = 0; passed < ms && !over_.load(); passed += 5) {
            if (bed_->with([](FalconEmulator& f) { return f.hasMotorForce(); })) pushed_.store(true);
            sleepMs(5);
        }
    }
    void hold(double z_m) {
        const Vec3 angles = haptics::falcon::anglesAt({0.0, 0.0, z_m}).value();
        std::array<int, 3> counts{};
        for (int i = 0; i < 3; ++i)
            counts[std::size_t(i)] = int(std::lround(haptics::falcon::countsFromRadians(angles[i])));
        bed_->with([&](FalconEmulator& f) { f.moveTo(counts); });
    }

    // Position 3 mm outside the skin. The path's entry lies 15 mm inside the near end of the workspace
    // (clutch.h).
    const double outside_m_ = haptics::falcon::makeProfile({}).workspace_centre_m.z +
                              haptics::falcon::makeProfile({}).workspace_radius_m - 0.012;
    test::FalconTestbed* bed_;
    std::filesystem::path out_;
    std::atomic<bool> over_{false}, pushed_{false};
    std::atomic<int> passes_{0};
    std::thread thread_;
};

// Needs real time. Whatever ends the program, including signals from a terminal, the last command to the
// motors is zero.
struct FalconRunRealTime : testing::Test {
    void SetUp() override {
        if (!test::FalconTestbed::works()) GTEST_SKIP() << "umockdev's library is not preloaded: use ctest";
        std::ofstream(command / "image") << "abc";
    }
    std::string arguments(const std::string& rest) {
        return "run --headless --fps 0 --spacing-mm 2.5 --device falcon --firmware '" +
               (command / "image").string() + "' --scenario '" + test::testScenario("short").string() + "' " +
               rest;
    }
    // Runs an attempt into `out`. Sends `signal` once `seen` returns true; otherwise the attempt ends after
    // four minutes.
    test::Outcome runUntil(const std::function<bool()>& seen, const std::filesystem::path& out, int signal,
                           const std::string& options = "") {
        const std::filesystem::path number = out.string() + "-number";
        test::Outcome live;
        std::atomic<bool> over{false};
        std::thread program([&] {
            live = command.runInto(out, arguments("--seconds 240 " + options), number);
            over.store(true);
        });
        while (!over.load() && !seen())
            sleepMs(10);
        if (!over.load()) test::signalProgram(number, signal);
        program.join();
        return live;
    }
    test::Command command;
};

TEST_F(FalconRunRealTime, PushesTheHandEndsInZeroAndItsRecordReplays) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const std::filesystem::path out = command / "live";
    test::Outcome live;
    {
        const Work work(bed, out);
        live = runUntil([&] { return work.passes() > 0; }, out, SIGINT);
        EXPECT_TRUE(work.pushed()) << live.err;
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_THAT(live.err, HasSubstr("falcon: ready"));
    EXPECT_EQ(live.summary.at("device"), "falcon");
    EXPECT_EQ(live.summary.at("firmware_sha256"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_FALSE(live.summary.at("punctures").empty());
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.hasMotorForce()); });
    const test::Outcome again = command.run("replay '" + (out / "record").string() + "' --fast");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));
}

// A stopped program would leave the motors pushing. All signals are caught in the same way
// (platform_linux_test.cpp); the test above ends by SIGINT.
// HZ-FORCE-14
TEST_F(FalconRunRealTime, ASignalWhileItPushesEndsInZero) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const std::filesystem::path out = command / "stopped";
    test::Outcome live;
    {
        const Work work(bed, out);
        live = runUntil([&] { return work.pushed(); }, out, SIGTSTP);
        EXPECT_TRUE(work.pushed());
    }
    EXPECT_EQ(live.status, 0) << live.err;
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.hasMotorForce()); });
    EXPECT_LT(live.summary.at("haptics").at("ticks").get<double>(), 240'000.0) << live.err;
}

// It would hold the needle along the planned path. HZ-TEACH-24
TEST_F(FalconRunRealTime, OnlyAnExamRefusesADeviceThatSensesNoRotation) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const Hand hand(bed);
    for (const std::string difficulty : {"guided", "exam"}) {
        SCOPED_TRACE(difficulty);
        const test::Outcome live = command.run(arguments("--seconds 0.2 --difficulty " + difficulty));
        const bool exam = difficulty == "exam";
        EXPECT_EQ(live.status == 0, !exam) << live.err;
        EXPECT_EQ(live.err.find("senses no rotation") != std::string::npos, exam) << live.err;
        EXPECT_EQ(std::filesystem::exists(command.out() / "record"), !exam);
        bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.hasMotorForce()); });
    }
    // An instructor who asks for an exam while a practice runs, and for the next attempt: the program goes
    // on, with the practice and its reason.
    const std::filesystem::path out = command / "turned", words = command / "words";
    std::ofstream(words) << "difficulty exam\nnew attempt\n";
    const test::Outcome turned =
        runUntil([&] { return std::filesystem::exists(out.string() + "-2/record/samples.bin"); }, out, SIGINT,
                 "--difficulty practice <'" + words.string() + "'");
    EXPECT_EQ(turned.status, 0) << turned.err;
    EXPECT_THAT(turned.err, HasSubstr("senses no rotation"));
    EXPECT_LT(turned.err.find("falcon: ready"), turned.err.find("senses no rotation"))
        << "the first practice ran";
    EXPECT_THAT(turned.err, HasSubstr("This attempt has the settings of the last one: practice."));
    EXPECT_TRUE(std::filesystem::exists(out / "summary.json")) << "the last attempt's results";
    EXPECT_THAT(test::readText(out.string() + "-2/record/record.json"),
                HasSubstr("\"difficulty\": \"practice\""));
}

TEST_F(FalconRunRealTime, CancelledCalibrationReleasesTheForce) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const std::string file = (command / "falcon.toml").string(), words = (command / "words").string();
    const std::string line = "printf '250\\nmany\\n352\\n' | '" + std::string(std::getenv("STYLET_BIN")) +
                             "/stylet' devices --calibrate '" + file + "' >'" + words + "' 2>&1";
    int status = 0;
    std::string said;
    // On a busy machine the emulated device may not answer for 20 ms, which also ends the calibration.
    for (int tries = 0; tries < 40 && said.find("stopped") == std::string::npos; ++tries) {
        const Hand hand(bed);
        status = std::system(line.c_str());
        said = test::readText(words);
    }
    EXPECT_EQ(WEXITSTATUS(status), 2) << said;
    EXPECT_THAT(said, HasSubstr("Leave the Falcon upright"));
    EXPECT_THAT(said, HasSubstr("Enter a number"));
    EXPECT_THAT(said, HasSubstr("stopped"));
    EXPECT_FALSE(std::filesystem::exists(file));
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.hasMotorForce()); });
}

}  // namespace
}  // namespace stylet::trainer
