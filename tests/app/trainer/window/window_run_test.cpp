// `stylet run` with a window, as a user runs it, on an X server without a screen.
#include <algorithm>
#include <chrono>
#include <future>
#include <thread>

#include <gtest/gtest.h>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using test::Outcome;

class WindowRun : public testing::Test {
  protected:
    static void SetUpTestSuite() { command_ = new test::Command; }
    static void TearDownTestSuite() { delete command_; }
    void TearDown() override { command_->unset("XR_RUNTIME_JSON"); }
    void start(const std::string& options) {
        outcome_ = std::async(std::launch::async, [options] {
            return command_->run("run --spacing-mm 3 --scenario '" + test::testScenario("short").string() +
                                 "' " + options);
        });
    }
    // The window is there and shows something other than its captions.
    bool shown() const {
        for (int i = 0; i < 3000 && outcome_.wait_for(10ms) != std::future_status::ready; ++i) {
            const test::Screenshot shot = display_.shot();
            if (shot.rgb.empty()) continue;
            int coloured = 0;
            for (std::size_t at = 0; at + 2 < shot.rgb.size(); at += 300)
                coloured += std::max({shot.rgb[at], shot.rgb[at + 1], shot.rgb[at + 2]}) > 60;
            if (coloured > 300) return true;
        }
        return false;
    }

    test::XDisplay display_{1400, 900};
    static inline test::Command* command_ = nullptr;  // one patient for all
    std::future<Outcome> outcome_;
};

// HZ-RECORD-12
TEST_F(WindowRun, ADisplayThatGoesAwayTakesTheMirrorAndNothingElse) {
    start("--headless --mirror --validation");
    EXPECT_TRUE(shown());
    display_.kill();
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>());
    EXPECT_NE(outcome.err.find("the window was lost"), std::string::npos) << outcome.err;
    for (const char* eye : {"duct_left.png", "duct_right.png"})
        EXPECT_TRUE(std::filesystem::exists(command_->out() / eye)) << eye;
}

TEST_F(WindowRun, WithoutAHeadsetTheWindowTakesItsPlace) {
    command_->set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    start("--validation");
    EXPECT_TRUE(shown());
    EXPECT_NE(display_.title().find("Stylet"), std::string::npos);
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("a window takes its place"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("validation"), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>());
    for (const std::string moment : {"approach", "skin", "fascia", "liver", "duct"})
        EXPECT_GT(std::filesystem::file_size(command_->out() / (moment + "_view.png")), 20000u) << moment;
}

TEST_F(WindowRun, WithNeitherThereIsOneSentenceAndNoPicture) {
    display_.kill();
    command_->set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    start("--mirror");
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("nor a window: no display"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("continuing without pictures"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.summary.at("frames"), 0);
}

}  // namespace
}  // namespace stylet::trainer
