// The whole procedure at a window, by mouse and keys alone, as somebody without a headset or a device does
// it.
#include <chrono>
#include <functional>
#include <future>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/kept_attempt.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using test::Outcome;

class DesktopRun : public testing::Test {
  protected:
    void start(const std::string& options) {
        outcome_ = std::async(std::launch::async,
                              [this, options] { return command_.runBare("run --spacing-mm 3 " + options); });
    }
    bool over() const { return outcome_.wait_for(0ms) == std::future_status::ready; }
    bool until(const std::function<bool()>& done, std::chrono::seconds most = 300s) const {
        for (const auto begin = std::chrono::steady_clock::now(); !done(); std::this_thread::sleep_for(20ms))
            if (over() || std::chrono::steady_clock::now() > begin + most) return false;
        return true;
    }
    // What the program has said so far.
    std::string said() const { return test::textOf(command_ / "stderr"); }
    bool says(const std::string& text) const {
        return until([&] { return said().find(text) != std::string::npos; });
    }
    // Until the attempt's events have it, for the `times`th time.
    bool happens(const std::string& kind, const std::string& text, int times = 1) const {
        const std::string id = test::newestAttempt(command_).filename().string();
        const records::Store store(test::storeOf(command_));
        return until([&] { return test::countOf(store.attempt(id), kind, text) >= times; });
    }
    // The same, `act` being done until it does: on a slow machine two moves may come to one.
    bool happensBy(const std::function<void()>& act, const std::string& kind, const std::string& text) const {
        const std::string id = test::newestAttempt(command_).filename().string();
        const records::Store store(test::storeOf(command_));
        for (int times = 0; times < 20; ++times) {
            act();
            if (until([&] { return test::countOf(store.attempt(id), kind, text) > 0; }, 10s)) return true;
        }
        return false;
    }
    // The same, the tool being moved about in a widening square of key steps until it does, and back again:
    // where the duct is seen depends on ribs and on the breath that was held.
    bool happensAround(const std::string& kind, const std::string& text) const {
        const std::string id = test::newestAttempt(command_).filename().string();
        const records::Store store(test::storeOf(command_));
        const auto happened = [&] { return test::countOf(store.attempt(id), kind, text) > 0; };
        bool found = until(happened, 5s);
        constexpr const char* kTurns[] = {"Right", "Up", "Left", "Down"};
        std::vector<int> made;
        for (int side = 0; side < 12 && !found; ++side)
            for (int step = 0; step <= side / 2 && !found; ++step) {
                display_.key(kTurns[side % 4]);
                made.push_back(side % 4);
                found = until(happened, 2s);
            }
        for (; !made.empty(); made.pop_back())
            steps(kTurns[(made.back() + 2) % 4], 1, 100ms);
        return found;
    }
    // The tool follows without haste.
    void steps(const std::string& key, int times, std::chrono::milliseconds wait = 2s) const {
        display_.key(key, times);
        std::this_thread::sleep_for(wait);
    }

    test::XDisplay display_{1500, 950};
    test::Command command_;
    std::future<Outcome> outcome_;
};

TEST_F(DesktopRun, FromPalpationToDuctsFullOfContrastByMouseAndKeys) {
    // His second best path: a probe laid on its entry sees the duct in any breath, on the best it does in
    // few.
    start("--device mouse --scenario procedure --path 2 --trainee mouse-1");
    ASSERT_TRUE(says("the hand is yours")) << said();
    ASSERT_TRUE(until([&] { return !display_.title().empty(); }));

    steps("Next", 16);  // Page Down: the finger on the skin, then along it with the mouse
    display_.drag(500, 260, 520, 260);
    ASSERT_TRUE(happens("step", "find the space between the ribs")) << said();
    steps("Home", 1);

    display_.key("p");
    ASSERT_TRUE(says("the probe is in hand")) << said();
    display_.key("h");
    ASSERT_TRUE(says("asked to hold his breath")) << said();
    display_.key("e", 18);  // between the ribs
    ASSERT_TRUE(happens("breath", "held")) << said();
    steps("Next", 16);
    ASSERT_TRUE(happensAround("step", "find the duct")) << said();
    display_.key("k");
    ASSERT_TRUE(says("the probe stays where it is")) << said();
    steps("Home", 1);

    display_.key("s");
    ASSERT_TRUE(says("the scalpel is in hand")) << said();
    steps("Next", 17);
    display_.key("Up", 2);
    ASSERT_TRUE(happens("step", "open the skin")) << said();
    steps("Home", 1);

    display_.key("space");  // the next tool
    ASSERT_TRUE(says("the guide is in hand")) << said();
    const auto beside_and_in = [&] {  // it holds the needle
        steps("Right", 1, 1s);
        steps("Left", 1, 1s);
    };
    ASSERT_TRUE(happensBy(beside_and_in, "step", "snap the needle into the guide")) << said();
    display_.key("n");
    ASSERT_TRUE(says("the needle is in hand")) << said();
    const json path =
        json::parse(test::textOf(test::newestAttempt(command_) / "record" / "record.json")).at("path");
    const double length_mm = 1e3 * path.at("length_m").get<double>();
    steps("Next", 15);                    // to the skin
    const int rest = int(length_mm) + 1;  // a step of the wheel is a millimetre
    for (int i = 0; i < rest; i += 10) {
        display_.wheel(500, 260, std::min(10, rest - i));
        std::this_thread::sleep_for(500ms);
    }
    ASSERT_TRUE(happens("step", "advance to the duct")) << said();
    display_.key("x");
    EXPECT_TRUE(says("X-rays")) << said();
    display_.key("i");
    EXPECT_TRUE(says("contrast medium, 1 ml/s")) << said();
    ASSERT_TRUE(happens("step", "show the ducts with contrast")) << said();
    display_.key("i");
    EXPECT_TRUE(says("no more contrast medium")) << said();
    display_.key("x");
    EXPECT_TRUE(says("no more X-rays")) << said();

    // The instructor at the same window: what he injects is in the record, what he says in the log.
    display_.key("F7");
    EXPECT_TRUE(says("instructor: lights out")) << said();
    display_.key("F8");
    EXPECT_TRUE(says("instructor: bookmark")) << said();
    display_.key("F9");
    for (const char* letter : {"t", "o", "o", "space", "f", "a", "s", "t"})
        display_.key(letter);
    display_.key("Return");
    EXPECT_TRUE(says("instructor: comment: too fast")) << said();
    display_.key("F10");
    EXPECT_TRUE(says("instructor: pause: paused")) << said();
    std::this_thread::sleep_for(1s);
    display_.key("F10");
    EXPECT_TRUE(says("instructor: pause: goes on")) << said();
    for (const auto& [key, name] :
         {std::pair{"F2", "cough"}, {"F4", "bleed"}, {"F5", "move"}, {"F6", "fault"}}) {
        display_.key(key);
        EXPECT_TRUE(says("instructor: " + std::string(name))) << said();
        std::this_thread::sleep_for(1500ms);
    }
    display_.close();
    const test::KeptAttempt kept = test::storedReplayedReported(command_, outcome_.get(), "mouse-1");
    test::expectWholeProcedure(kept);
    EXPECT_EQ(kept.stored.info.device, "mouse");
    EXPECT_GT(kept.stored.result->total, 50.0);
    for (const haptics::CommandKind kind : {haptics::CommandKind::cough, haptics::CommandKind::bleed,
                                            haptics::CommandKind::move, haptics::CommandKind::fault})
        EXPECT_EQ(kept.commanded[std::size_t(kind)], 1) << int(kind);
    EXPECT_NE(kept.page.find("too fast"), std::string::npos) << "the instructor's word is on the page";
}

TEST_F(DesktopRun, WithoutADisplayThereIsNoMouse) {
    display_.kill();
    start("--device mouse --trainee mouse-2 --scenario '" + test::testScenario("short").string() + "'");
    const Outcome outcome = outcome_.get();
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("its hand is in a window, and there is none"), std::string::npos)
        << outcome.err;
}

}  // namespace
}  // namespace stylet::trainer
