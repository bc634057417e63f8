// Runs `stylet run` with a window as a user does, on an X server without a screen. Most tests use a virtual
// clock, so a slow machine only takes longer.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <future>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/app/trainer/command.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using test::Outcome;

// A scenario with all capture points and a hit within two seconds. The patient breathes fast, so that the
// breath-hold begins soon.
constexpr const char* kTwoSeconds = R"(name = "two seconds"
description = "The short scenario with a fast breath and a faster hand."
moments = ["approach", "skin", "fascia", "liver", "duct"]
approach_distance_mm = 5.0
[start]
deeper_mm = -8.0
[hand]
ramp_s = 0.1
tremor_mm = 0.1
tremor_low_hz = 8.0
tremor_high_hz = 10.0
[breath]
period_s = 1.0
[[stage]]
do = "hold"
seconds = 0.05
[[stage]]
do = "move"
share = 1.0
deeper_mm = 1.0
speed_mm_s = 100.0
[[stage]]
do = "wait"
seconds = 0.1
)";

class WindowRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        command_ = new test::Command;
        std::ofstream(*command_ / "two_seconds.toml") << kTwoSeconds;
    }
    static void TearDownTestSuite() { delete command_; }
    void TearDown() override { command_->unset("XR_RUNTIME_JSON"); }
    void start(const std::string& options) {
        outcome_ = std::async(std::launch::async, [options] {
            return command_->run("run --spacing-mm 3 --scenario '" +
                                 (*command_ / "two_seconds.toml").string() + "' " + options);
        });
    }
    // Waits until the window shows more than its captions.
    bool shown() const {
        const auto begin = std::chrono::steady_clock::now();
        while (outcome_.wait_for(50ms) != std::future_status::ready) {
            if (std::chrono::steady_clock::now() > begin + 120s) return false;
            const test::Screenshot shot = display_->shot();
            if (shot.rgb.empty()) continue;
            int coloured = 0;
            for (std::size_t at = 0; at + 2 < shot.rgb.size(); at += 300)
                coloured += std::max({shot.rgb[at], shot.rgb[at + 1], shot.rgb[at + 2]}) > 60;
            if (coloured > 300) return true;
        }
        return false;
    }

    std::optional<test::XDisplay> display_{std::in_place, 1400, 900};
    static inline test::Command* command_ = nullptr;  // one patient for all tests
    std::future<Outcome> outcome_;
};

// HZ-RECORD-12
TEST_F(WindowRun, LostDisplayEndsOnlyTheMirror) {
    Outcome outcome;
    bool lost = false;
    // Try again if the attempt ended before the window was shown or before the loss was noticed.
    for (int tries = 0; tries < 20 && !lost; ++tries) {
        display_.emplace(1400, 900);
        start("--fast --fps 4 --headless --mirror --validation");
        const bool was_shown = shown();
        display_->kill();
        outcome = outcome_.get();
        lost = was_shown && outcome.err.find("the window was lost") != std::string::npos;
    }
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>());
    EXPECT_TRUE(lost) << outcome.err;
    for (const char* eye : {"duct_left.png", "duct_right.png"})
        EXPECT_TRUE(std::filesystem::exists(command_->out() / eye)) << eye;
}

// If a display is available and no headset is found, the program opens a window by itself, but only in real
// time. So this test cannot use a virtual clock. It checks only the captured pictures: on a slow machine the
// attempt may end before the window shows one.
using WindowRunRealTime = WindowRun;

TEST_F(WindowRunRealTime, WindowReplacesAMissingHeadset) {
    command_->set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    display_.emplace(700, 450);  // fewer pixels to draw
    start("--validation");
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("using a window instead"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("validation"), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>());
    for (const std::string moment : {"approach", "skin", "fascia", "liver", "duct"})
        EXPECT_GT(std::filesystem::file_size(command_->out() / (moment + "_view.png")), 20000u) << moment;
}

TEST_F(WindowRun, WindowWithoutHeadsetShowsTheRoom) {
    command_->set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    start("--fast --fps 4 --mirror --validation");
    EXPECT_TRUE(shown());
    EXPECT_NE(display_->title().find("Stylet"), std::string::npos);
    display_->close();
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("validation"), std::string::npos) << outcome.err;
}

TEST_F(WindowRun, MissingHeadsetAndDisplayAreReportedInOneLine) {
    display_->kill();
    command_->set("XR_RUNTIME_JSON", "/nowhere/runtime.json");
    start("--fast --fps 4 --mirror");
    const Outcome outcome = outcome_.get();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("no window either: no display"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("continuing without pictures"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.summary.at("frames"), 0);
}

}  // namespace
}  // namespace stylet::trainer
