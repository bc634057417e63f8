// The main job with its pictures: loader, mock runtime, Vulkan. A small patient with a quick breath.
#include <gtest/gtest.h>

#include "app/trainer/run.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using test::Command;
using test::Outcome;

const std::vector<std::string> kMoments{"approach", "skin", "fascia", "liver", "duct"};

class RunWithPictures : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new Command;
        // Made through the program, then given a breath of one second: a hold is certain sooner.
        command_->run("run --fast --spacing-mm 2.5 --scenario '" + test::testScenario("short").string() +
                      "'");
        const std::filesystem::path made =
            std::filesystem::directory_iterator(*command_ / "cache" / "stylet" / "patients")->path();
        patient::Package package = patient::loadPackage(made);
        package.signal.period_s = 1.0;
        patient::savePackage(package, *command_ / "quick");
        run_ = "run --headless --scenario '" + test::testScenario("short").string() + "' --patient '" +
               (*command_ / "quick").string() + "'";
        without_ = new Outcome(command_->run(run_ + " --fast --fps 0"));
    }
    static void TearDownTestSuite() {
        delete without_;
        delete command_;
    }
    static std::string hashOf(const Outcome& outcome) {
        return outcome.summary.at("state_hash").get<std::string>();
    }
    static void expectPicturesOfEveryMoment() {
        for (const std::string& moment : kMoments)
            for (const char* eye : {"_left.png", "_right.png"}) {
                const std::filesystem::path file = command_->out() / (moment + eye);
                ASSERT_TRUE(std::filesystem::exists(file)) << file;
                EXPECT_GT(std::filesystem::file_size(file), 20000u)
                    << file;  // an empty picture is far smaller
            }
    }

    static inline Command* command_ = nullptr;
    static inline Outcome* without_ = nullptr;
    static inline std::string run_;
};

TEST_F(RunWithPictures, FramesPerSecondNeverEnterTheHash) {
    ASSERT_EQ(without_->status, 0) << without_->err;
    EXPECT_TRUE(without_->summary.at("target_hit").get<bool>());
    EXPECT_EQ(without_->summary.at("frames"), 0);
    const double seconds = without_->summary.at("haptics").at("ticks").get<double>() / 1000.0;
    for (const int fps : {1, 10}) {
        const Outcome outcome = command_->run(run_ + " --fast --fps " + std::to_string(fps));
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        EXPECT_EQ(hashOf(outcome), hashOf(*without_)) << fps;
        EXPECT_GE(outcome.summary.at("frames").get<double>(), seconds * fps);
        expectPicturesOfEveryMoment();
    }
}

TEST_F(RunWithPictures, RealTimeCatchesEveryMomentAndReplaysToItsHash) {
    const Outcome outcome = command_->run(run_ + " --stats");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>());
    EXPECT_EQ(outcome.summary.at("haptics").at("faults"), 0);
    EXPECT_GE(outcome.summary.at("frames").get<std::size_t>(), kMoments.size());
    EXPECT_GT(outcome.summary.at("skips").at("skipped_bricks").get<std::uint64_t>(), 0u);
    EXPECT_NE(outcome.out.find("skipped_bricks"), std::string::npos);
    expectPicturesOfEveryMoment();
    const Outcome replay = command_->run("replay '" + command_->out().string() + "' --fast");
    EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
    EXPECT_EQ(hashOf(replay), hashOf(outcome));
}

TEST_F(RunWithPictures, TheValidationLayersAreSilent) {
    const Outcome outcome = command_->run(run_ + " --fast --fps 1 --validation");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_GT(outcome.summary.at("frames").get<int>(), 0);
    EXPECT_EQ(outcome.summary.at("validation_messages"), 0) << outcome.err;
}

}  // namespace
}  // namespace stylet::trainer
