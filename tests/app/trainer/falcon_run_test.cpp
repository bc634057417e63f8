// `stylet run --device falcon` and its calibration, as a user calls them, with an emulated Falcon plugged in.
#include <gtest/gtest.h>

#include <signal.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <thread>

#include "haptics/devices/falcon.h"
#include "haptics/devices/falcon_kinematics.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/support/falcon_testbed.h"

namespace stylet::trainer {
namespace {

using test::FalconEmulator;

// The hand that homes it, for as long as it is in scope.
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

void nap(int ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

// A hand at work on an attempt that writes into `out`: still until the record begins and the force has risen,
// then along the path into the body, held there, and drawn back again. It re-arms where a busy machine made a
// fault of the emulated device.
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
    // Until the motors push, at most 20 s.
    bool waitForPush() const {
        for (int i = 0; i < 2000 && !pushed(); ++i)
            nap(10);
        return pushed();
    }

  private:
    void run() {
        hold(outside_m_);
        while (!over_.load() && !std::filesystem::exists(out_ / "record")) {
            bed_->with([](FalconEmulator& f) { f.home(); });
            nap(20);
        }
        while (!over_.load()) {
            bed_->with([](FalconEmulator& f) { f.press(1); });
            stay(100);
            bed_->with([](FalconEmulator& f) { f.press(0); });
            stay(1700);
            for (int mm = 0; mm <= 30; ++mm)
                stay(20, outside_m_ - 0.001 * mm);
            stay(2000);
            for (int mm = 30; mm >= 0; --mm)
                stay(20, outside_m_ - 0.001 * mm);
        }
    }
    void stay(int ms, std::optional<double> z_m = {}) {
        if (z_m) hold(*z_m);
        for (int passed = 0; passed < ms && !over_.load(); passed += 10) {
            if (bed_->with([](FalconEmulator& f) { return f.pushes(); })) pushed_.store(true);
            nap(10);
        }
    }
    void hold(double z_m) {
        const haptics::Vec3 angles = haptics::falcon::anglesAt({0.0, 0.0, z_m}).value();
        std::array<int, 3> counts{};
        for (int i = 0; i < 3; ++i)
            counts[std::size_t(i)] = int(std::lround(haptics::falcon::countsFromRadians(angles[i])));
        bed_->with([&](FalconEmulator& f) { f.holdAt(counts); });
    }

    // The path's entry is 15 mm within the workspace's near end (clutch.h), this 3 mm outside the skin.
    const double outside_m_ = haptics::falcon::profileOf({}).workspace_centre_m.z +
                              haptics::falcon::profileOf({}).workspace_radius_m - 0.012;
    test::FalconTestbed* bed_;
    std::filesystem::path out_;
    std::atomic<bool> over_{false}, pushed_{false};
    std::thread thread_;
};

struct FalconRun : testing::Test {
    void SetUp() override {
        if (!test::FalconTestbed::works()) GTEST_SKIP() << "umockdev's library is not preloaded: use ctest";
        std::ofstream(command / "image") << "abc";
    }
    std::string arguments(const std::string& rest) {
        return "run --headless --fps 0 --spacing-mm 2.5 --device falcon --firmware '" +
               (command / "image").string() + "' --scenario '" + test::testScenario("short").string() + "' " +
               rest;
    }
    test::Command command;
};

TEST_F(FalconRun, PushesTheHandEndsInZeroAndItsRecordReplays) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const std::filesystem::path out = command / "live";
    test::Outcome live;
    {
        const Work work(bed, out);
        live = command.runInto(out, arguments("--seconds 9"));
        EXPECT_TRUE(work.pushed()) << live.err;
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("falcon: ready"), std::string::npos) << live.err;
    EXPECT_EQ(live.summary.at("device"), "falcon");
    EXPECT_EQ(live.summary.at("firmware_sha256"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_FALSE(live.summary.at("punctures").empty());
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.pushes()); });
    const test::Outcome again = command.run("replay '" + (out / "record").string() + "' --fast");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));
}

// Whatever a terminal does to a program, its motors are told zero before it is gone.
TEST_F(FalconRun, ASignalWhileItPushesEndsInZero) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP}) {
        SCOPED_TRACE(strsignal(signal));
        const std::filesystem::path out = command / ("signal" + std::to_string(signal)),
                                    number = command / ("number" + std::to_string(signal));
        test::Outcome live;
        {
            const Work work(bed, out);
            std::thread program([&] { live = command.runInto(out, arguments("--seconds 60"), number); });
            const bool pushed = work.waitForPush();
            EXPECT_TRUE(pushed);
            const int process = std::atoi(test::textOf(number).c_str());
            if (process > 0) kill(process, signal);
            program.join();
        }
        EXPECT_EQ(live.status, 0) << live.err;
        bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.pushes()); });
        EXPECT_LT(live.summary.at("haptics").at("ticks").get<double>(), 50'000.0);
    }
}

TEST_F(FalconRun, ACalibrationThatIsBrokenOffSaysSoAndLetsGo) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const std::string file = (command / "falcon.toml").string(), words = (command / "words").string();
    const std::string line = "printf '250\\nmany\\n352\\n' | '" + std::string(std::getenv("STYLET_BIN")) +
                             "/stylet' devices --calibrate '" + file + "' >'" + words + "' 2>&1";
    int status = 0;
    std::string said;
    // On a busy machine the emulated device may well be silent for 20 ms, which ends it too.
    for (int tries = 0; tries < 10 && said.find("stopped") == std::string::npos; ++tries) {
        const Hand hand(bed);
        status = std::system(line.c_str());
        said = test::textOf(words);
    }
    EXPECT_EQ(WEXITSTATUS(status), 2) << said;
    EXPECT_NE(said.find("Leave the Falcon upright"), std::string::npos) << said;
    EXPECT_NE(said.find("A number, please"), std::string::npos) << said;
    EXPECT_NE(said.find("stopped"), std::string::npos) << said;
    EXPECT_FALSE(std::filesystem::exists(file));
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.pushes()); });
}

}  // namespace
}  // namespace stylet::trainer
