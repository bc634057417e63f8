// A window with mouse and keys only, as used without headset and device.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <optional>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/window/camera_view.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/program/kept_attempt.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using haptics::Tool;
using test::Outcome;

// Tool motion per key press. One step of the wheel is a millimetre.
constexpr double kKeyStep_m = 0.002, kKeyStep_rad = 0.035;

// Position of a tool relative to its start, in key presses.
struct KeySteps {
    double right = 0.0, up = 0.0, deeper = 0.0, rolled = 0.0;  // rolled: with Q
};

bool isNear(const KeySteps& a, const KeySteps& b) {
    constexpr double kNear = 0.25;
    return std::fabs(a.right - b.right) < kNear && std::fabs(a.up - b.up) < kNear &&
           std::fabs(a.deeper - b.deeper) < kNear && std::fabs(a.rolled - b.rolled) < kNear;
}

// Converts tool poses to key presses, for the patient and the path of an attempt.
class KeyFrame {
  public:
    explicit KeyFrame(const records::Record& record) : guide_(record.header.settings.tools.guide) {
        const patient::Package package = patient::loadPackage(record.info.patient_folder);
        const patient::Patient patient(package);
        const patient::PlannedPath& path = record.info.path;
        start_ = mouseStart(training::StartPlace::path, patient, path, 0);
        const Pose stage_from_patient = stageFromPatient(patient, fieldOf(path));
        const Pose patient_from_eye = stage_from_patient.inverse() *
                                      operatorView(stage_from_patient, fieldOf(path), 1.0).stage_from_eye;
        patient_from_keys_ = {patient_from_eye.direction({1, 0, 0}), patient_from_eye.direction({0, 1, 0}),
                              start_.direction({0, 0, -1})};
    }

    KeySteps stepsAt(const Pose& patient_from_tool, Tool tool) const {
        const Pose needle = patient_from_tool * toolPoseFromNeedle({}, tool, guide_).inverse();
        const Vec3 steps =
            glm::inverse(patient_from_keys_) * (needle.position_m - start_.position_m) / kKeyStep_m;
        const Quat roll = glm::conjugate(start_.rotation) * needle.rotation;
        return {steps.x, steps.y, steps.z, 2.0 * std::atan(roll.z / roll.w) / kKeyStep_rad};
    }

  private:
    haptics::GuideSettings guide_;
    Pose start_;
    glm::dmat3 patient_from_keys_{1.0};  // columns: right, up, deeper
};

class DesktopRun : public testing::Test {
  protected:
    static void SetUpTestSuite() { command_ = new test::Command; }
    static void TearDownTestSuite() { delete command_; }
    void start(const std::string& options) {
        outcome_ = std::async(std::launch::async,
                              [options] { return command_->runBare("run --spacing-mm 3 " + options); });
    }
    // After a failure, the program still runs.
    void TearDown() override {
        if (outcome_.valid() && !over()) display_.close();
    }
    bool over() const { return outcome_.wait_for(0ms) == std::future_status::ready; }
    bool until(const std::function<bool()>& done, std::chrono::seconds most = 120s) const {
        for (const auto begin = std::chrono::steady_clock::now(); !done(); std::this_thread::sleep_for(20ms))
            if (over() || std::chrono::steady_clock::now() > begin + most) return false;
        return true;
    }
    // Everything that the program has printed on stderr.
    std::string printed() const { return test::readText(*command_ / "stderr"); }
    bool says(const std::string& text, std::chrono::seconds most = 120s) const {
        return until([&] { return printed().find(text) != std::string::npos; }, most);
    }
    // Waits until the attempt's log contains this event.
    bool happens(const std::string& kind, const std::string& text) const {
        const std::filesystem::path attempt = test::newestAttempt(*command_);
        return until([&] { return test::countOf(attempt, kind, text) > 0; });
    }
    std::filesystem::path record() const { return test::newestAttempt(*command_) / "record"; }

    // Reads the newest frame of stored samples of the attempt. Returns false if there is none yet.
    bool readSamples() {
        std::error_code none;
        const std::uintmax_t bytes = std::filesystem::file_size(record() / "samples.bin", none);
        if (!none && bytes != samples_bytes_) {
            const std::vector<records::Sample> all = records::loadSamples(record()).samples;
            newest_.assign(all.end() - std::min(std::ptrdiff_t(all.size()), std::ptrdiff_t(kFrame)),
                           all.end());
            samples_bytes_ = bytes;
        }
        return newest_.size() == kFrame;
    }
    // Returns true if this tool was in use and at rest during the whole newest frame.
    bool rests(Tool tool) {
        if (!readSamples()) return false;
        const KeySteps last = stepsNow();
        return std::all_of(newest_.begin(), newest_.end(), [&](const records::Sample& sample) {
            const KeySteps at = keys_->stepsAt(sample.patient_from_tool, sample.tool);
            return sample.tool == tool && std::fabs(at.right - last.right) + std::fabs(at.up - last.up) +
                                                  std::fabs(at.deeper - last.deeper) +
                                                  std::fabs(at.rolled - last.rolled) <
                                              0.1;
        });
    }
    // Returns true if the needle's tip is in tissue, so that it has punctured the skin.
    bool isInTissue() const {
        const records::Sample& now = newest_.back();
        return now.phase != haptics::Phase::outside && now.tissue != haptics::Tissue::air;
    }
    KeySteps stepsNow() const {
        return keys_->stepsAt(newest_.back().patient_from_tool, newest_.back().tool);
    }
    void press(const char* forth, const char* back, double steps) const {
        const int times = int(std::lround(steps));
        if (times != 0) display_.key(times > 0 ? forth : back, std::abs(times));
    }
    // Moves the tool with keys until the stored samples show it at rest at the goal. Repeats missing key
    // presses and reverses extra ones.
    bool bring(Tool tool, const KeySteps& goal) {
        const auto arrived = [&] { return rests(tool) && isNear(stepsNow(), goal); };
        for (int tries = 0; tries < 12; ++tries) {
            if (!until([&] { return rests(tool); })) return false;
            const KeySteps now = stepsNow();
            if (isNear(now, goal)) return true;
            // When the program stalls, it shortens a long motion, and the tool is left between two steps.
            if (isNear(goal, {}) || tries % 4 == 3) {
                display_.key("Home");
            } else {
                press("q", "e", goal.rolled - now.rolled);
                press("Right", "Left", goal.right - now.right);
                press("Up", "Down", goal.up - now.up);
                press("Next", "Prior", goal.deeper - now.deeper);
            }
            if (until(arrived, 10s)) return true;
        }
        return false;
    }
    // Repeats `act` until the program prints `text`.
    bool saysAfter(const std::function<bool()>& act, const std::string& text) const {
        for (int times = 0; times < 6; ++times) {
            if (!act()) return false;
            if (says(text, 5s)) return true;
        }
        return false;
    }
    std::string where() const {
        if (newest_.empty()) return "nowhere";
        const KeySteps at = stepsNow();
        return std::string(haptics::kToolNames[std::size_t(newest_.back().tool)]) + " at right " +
               std::to_string(at.right) + ", up " + std::to_string(at.up) + ", deeper " +
               std::to_string(at.deeper) + ", rolled " + std::to_string(at.rolled) + ", phase " +
               std::to_string(int(newest_.back().phase)) + ", force " +
               std::to_string(glm::length(newest_.back().tool_force_n)) + " N, breath " +
               std::to_string(newest_.back().breath_v) + (newest_.back().breath_held ? " held" : "") +
               ", faults " + std::to_string(newest_.back().faults) + "\n" + printed();
    }

    static constexpr std::size_t kFrame = records::kFrameTicks;
    test::XDisplay display_{1500, 950};
    static inline test::Command* command_ = nullptr;  // one patient for all tests
    std::future<Outcome> outcome_;
    std::optional<KeyFrame> keys_;
    std::vector<records::Sample> newest_;
    std::uintmax_t samples_bytes_ = 0;
};

// Need real time: X events at a real window move the tool, change it and send every command.
using DesktopRunRealTime = DesktopRun;

// Each key moves the tool or sends its command. hands/whole_course_test.cpp does the whole procedure with the
// same driver and keys. The order and the timing of X events of a real window vary. The test does not depend
// on the speed of the machine.
// HZ-TEACH-12
TEST_F(DesktopRunRealTime, MouseAndKeysMoveToolsAndSendCommands) {
    start("--device mouse --scenario procedure --path 2 --trainee mouse-1");
    ASSERT_TRUE(says("you control the ")) << printed();
    ASSERT_TRUE(until([&] { return !display_.title().empty(); }));
    display_.resize(720, 440);  // fewer pixels to draw
    ASSERT_TRUE(until([&] { return readSamples(); })) << printed();
    keys_.emplace(records::loadRecord(record()));
    ASSERT_TRUE(isNear(stepsNow(), {})) << where();

    ASSERT_TRUE(bring(Tool::finger, {.right = 2, .up = 3, .deeper = 4, .rolled = 5})) << where();
    ASSERT_TRUE(bring(Tool::finger, {.right = -2, .up = -1, .deeper = 1, .rolled = -3})) << where();
    ASSERT_TRUE(bring(Tool::finger, {})) << where();
    for (int tries = 0; tries < 12; ++tries) {  // a drag has no effect before the first picture
        display_.drag(250, 130, 270, 130);
        if (until([&] { return readSamples() && stepsNow().right > 1.0; }, 5s)) break;
    }
    EXPECT_GT(stepsNow().right, 1.0) << where();
    display_.key("Home");
    display_.key("h");
    ASSERT_TRUE(says("asked for a breath-hold")) << printed();
    ASSERT_TRUE(happens("breath", "held")) << where();

    display_.key("p");
    ASSERT_TRUE(says("the probe is in hand")) << printed();
    const auto park = [&] {  // after a leap, a probe cannot be parked until it was off the skin
        if (!bring(Tool::probe, {})) return false;
        display_.key("t");
        if (!until([&] { return rests(Tool::probe) && !isNear(stepsNow(), {}); })) return false;
        display_.key("k");
        return true;
    };
    ASSERT_TRUE(saysAfter(park, "the probe stays where it is")) << where();
    EXPECT_TRUE(says("the tool moves to the skin")) << printed();
    display_.key("Home");

    display_.key("s");
    ASSERT_TRUE(says("the scalpel is in hand")) << printed();
    display_.key("space");  // next tool
    ASSERT_TRUE(says("the guide is in hand")) << printed();
    display_.key("n");
    ASSERT_TRUE(says("the needle is in hand")) << printed();
    ASSERT_TRUE(bring(Tool::needle, {})) << where();
    // A bleeding needs a hole in the skin. How deep the skin is depends on the breath that is held.
    for (double deeper = 20.0; deeper <= 60.0 && !isInTissue(); deeper += 10.0)
        for (int tries = 0; tries < 12 && !isNear(stepsNow(), {.deeper = deeper}); ++tries) {
            display_.wheel(250, 130, int(std::lround(1e3 * kKeyStep_m * (deeper - stepsNow().deeper))));
            until([&] { return rests(Tool::needle) && isNear(stepsNow(), {.deeper = deeper}); }, 5s);
        }
    ASSERT_TRUE(isInTissue()) << where();
    display_.key("x");
    EXPECT_TRUE(says("X-rays")) << printed();
    display_.key("i");
    EXPECT_TRUE(says("contrast medium, 1 ml/s")) << printed();
    display_.key("i");
    EXPECT_TRUE(says("no more contrast medium")) << printed();
    display_.key("x");
    EXPECT_TRUE(says("no more X-rays")) << printed();

    // The instructor uses the same window: commands go into the record, comments into the log.
    display_.key("F7");
    EXPECT_TRUE(says("instructor: lights out")) << printed();
    display_.key("F8");
    EXPECT_TRUE(says("instructor: bookmark")) << printed();
    display_.key("F9");
    for (const char* letter : {"t", "o", "o", "space", "f", "a", "s", "t"})
        display_.key(letter);
    display_.key("Return");
    EXPECT_TRUE(says("instructor: comment: too fast")) << printed();
    display_.key("F10");
    EXPECT_TRUE(says("instructor: pause: paused")) << printed();
    display_.key("F10");
    EXPECT_TRUE(says("instructor: pause: goes on")) << printed();
    for (const auto& [key, name] : {std::pair{"F2", "cough"}, {"F4", "bleed"}, {"F5", "move"}}) {
        display_.key(key);
        EXPECT_TRUE(says("instructor: " + std::string(name))) << printed();
        EXPECT_TRUE(happens("injected", name)) << where();
    }
    display_.key("F6");
    EXPECT_TRUE(says("instructor: fault: not done")) << printed();
    // An exam places no tool and shows no expert.
    for (const char* difficulty : {"practice", "exam"}) {
        display_.key("F12");
        EXPECT_TRUE(says("instructor: difficulty: " + std::string(difficulty))) << printed();
    }
    display_.key("t");
    EXPECT_TRUE(says("not placed on the skin: this difficulty does not place tools")) << printed();
    display_.key("o");
    EXPECT_TRUE(says("the expert is shown in guided attempts only")) << printed();
    display_.close();
    const Outcome outcome = outcome_.get();
    test::expectNothingToRearm(outcome);
    const test::KeptAttempt kept = test::checkStoredAttempt(*command_, outcome, "mouse-1");
    EXPECT_EQ(kept.stored.info.device, "mouse");
    EXPECT_GT(kept.felt_n[std::size_t(Tool::probe)], 0.02);
    for (const haptics::CommandKind kind :
         {haptics::CommandKind::cough, haptics::CommandKind::bleed, haptics::CommandKind::move})
        EXPECT_EQ(kept.commanded[std::size_t(kind)], 1) << int(kind);
    EXPECT_EQ(kept.commanded[std::size_t(haptics::CommandKind::fault)], 0);
    EXPECT_THAT(kept.page, testing::HasSubstr("too fast")) << "the instructor's comment is on the page";
}

TEST_F(DesktopRun, MouseNeedsADisplay) {
    display_.kill();
    setenv("DISPLAY", ":50999", 1);  // another test may take the killed one's number
    start("--device mouse --trainee mouse-2 --scenario '" + test::testScenario("short").string() + "'");
    const Outcome outcome = outcome_.get();
    EXPECT_EQ(outcome.status, 3);
    EXPECT_THAT(outcome.err, testing::HasSubstr("--device mouse needs a window, and there is none"));
}

}  // namespace
}  // namespace stylet::trainer
