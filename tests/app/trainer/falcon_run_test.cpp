// `stylet run --device falcon` and its calibration, as a user calls them, with an emulated Falcon plugged in.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

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

struct FalconRun : testing::Test {
    void SetUp() override {
        if (!test::FalconTestbed::works()) GTEST_SKIP() << "umockdev's library is not preloaded: use ctest";
    }
    test::Command command;
};

TEST_F(FalconRun, MovesTheNeedleAndItsRecordReplays) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    std::ofstream(command / "image") << "abc";
    test::Outcome live;
    {
        const Hand hand(bed);
        live = command.run(
            "run --headless --fps 0 --spacing-mm 2.5 --seconds 1 --device falcon --firmware '" +
            (command / "image").string() + "' --scenario '" + test::testScenario("short").string() + "'");
    }
    ASSERT_EQ(live.status, 0) << live.err;
    EXPECT_NE(live.err.find("falcon: ready"), std::string::npos) << live.err;
    EXPECT_EQ(live.summary.at("device"), "falcon");
    EXPECT_EQ(live.summary.at("firmware_sha256"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.pushes()); });
    const test::Outcome again = command.run("replay '" + (command.out() / "record").string() + "' --fast");
    ASSERT_EQ(again.status, 0) << again.out << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), live.summary.at("state_hash"));
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
