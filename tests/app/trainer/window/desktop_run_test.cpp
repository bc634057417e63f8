// The whole procedure in a window with mouse and keys only, as done by a user without headset and device.
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
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/window/camera_view.h"
#include "app/training/attempt_fold.h"
#include "app/training/procedure.h"
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

// Converts between tool poses and key presses, for the patient and the path of an attempt.
class KeyFrame {
  public:
    explicit KeyFrame(const records::Record& record)
        : package_(patient::loadPackage(record.info.patient_folder)),
          patient_(package_),
          path_(record.info.path),
          guide_(record.header.settings.tools.guide),
          start_(mouseStart(training::StartPlace::path, patient_, path_, 0)) {
        const Pose stage_from_patient = stageFromPatient(patient_, fieldOf(path_));
        const Pose patient_from_eye = stage_from_patient.inverse() *
                                      operatorView(stage_from_patient, fieldOf(path_), 1.0).stage_from_eye;
        patient_from_keys_ = {patient_from_eye.direction({1, 0, 0}), patient_from_eye.direction({0, 1, 0}),
                              start_.direction({0, 0, -1})};
    }

    Pose patientFromTool(const KeySteps& at, Tool tool) const {
        const double half_rad = 0.5 * kKeyStep_rad * at.rolled;
        const Quat roll{std::cos(half_rad), 0.0, 0.0, std::sin(half_rad)};
        const Pose needle{
            start_.rotation * roll,
            start_.position_m + kKeyStep_m * (patient_from_keys_ * Vec3(at.right, at.up, at.deeper))};
        return toolPoseFromNeedle(needle, tool, guide_);
    }
    KeySteps stepsAt(const Pose& patient_from_tool, Tool tool) const {
        const Pose needle = patient_from_tool * toolPoseFromNeedle({}, tool, guide_).inverse();
        const Vec3 steps =
            glm::inverse(patient_from_keys_) * (needle.position_m - start_.position_m) / kKeyStep_m;
        const Quat roll = glm::conjugate(start_.rotation) * needle.rotation;
        return {steps.x, steps.y, steps.z, 2.0 * std::atan(roll.z / roll.w) / kKeyStep_rad};
    }
    // Places the probe at the path's entry, `deeper` key presses in, with its guide along the path. Finds the
    // range of rolls in which the program's own rule sees the target duct at this breath. Returns the middle
    // of the widest range, or nothing if there is none.
    std::optional<KeySteps> probeOnDuct(const patient::Surrogate& breath, double deeper) const;
    // The places `deeper` key presses in where the finger must press at this breath for the program's own
    // rule: the gap at the entry, then the ribs beside it. Empty if a rib is out of reach.
    std::vector<KeySteps> placesToFeel(const patient::Surrogate& breath, double deeper) const;
    // Key presses right, up and deeper, as fractions, that move the tool one key press across the path in the
    // patient's direction.
    Vec3 keysToward(const Vec3& patient_direction) const {
        const Vec3 axis = start_.direction({0, 0, -1});
        const Vec3 across = patient_direction - axis * glm::dot(patient_direction, axis);
        return glm::inverse(patient_from_keys_) * glm::normalize(across);
    }
    const patient::PlannedPath& path() const { return path_; }

  private:
    const patient::Package package_;
    const patient::Patient patient_;
    const patient::PlannedPath path_;
    const haptics::GuideSettings guide_;
    const Pose start_;
    glm::dmat3 patient_from_keys_{1.0};  // columns: right, up, deeper
};

std::optional<KeySteps> KeyFrame::probeOnDuct(const patient::Surrogate& breath, double deeper) const {
    constexpr int kMaxRolled = 45;
    constexpr double kLook_s = 1.0;  // long enough for the program to count the step as done
    const training::Procedure procedure(patient_, path_, kLook_s);
    const training::AttemptFold fold(patient_, kLook_s);
    const auto sees = [&](int rolled) {
        training::Procedure watching = procedure;
        haptics::TickOutput tick;
        tick.tool = Tool::probe;
        tick.probe_touching_share = 1.0;
        tick.patient_from_tool = patientFromTool({.deeper = deeper, .rolled = double(rolled)}, Tool::probe);
        tick.breath = breath;
        watching.update(tick, fold);
        return (watching.progress().steps_done & 1u << unsigned(training::Step::findDuct)) != 0;
    };
    std::optional<KeySteps> middle;
    int widest = 0, width = 0;
    for (int rolled = -kMaxRolled; rolled <= kMaxRolled; ++rolled) {
        width = sees(rolled) ? width + 1 : 0;
        if (width <= widest) continue;
        widest = width;
        middle = KeySteps{.deeper = deeper, .rolled = double(rolled - width / 2)};
    }
    return middle;
}

std::vector<KeySteps> KeyFrame::placesToFeel(const patient::Surrogate& breath, double deeper) const {
    constexpr int kMaxAway = 20;
    constexpr double kPress_s = 1.0;  // long enough for the program to count it
    training::Procedure procedure(patient_, path_, kPress_s);
    const training::AttemptFold fold(patient_, kPress_s);
    const auto press = [&](training::Procedure& on, const KeySteps& at) {
        haptics::TickOutput tick;
        tick.tool = Tool::finger;
        tick.tool_force.force_n = {1.0, 0.0, 0.0};
        tick.patient_from_tool = patientFromTool(at, Tool::finger);
        tick.breath = breath;
        on.update(tick, fold);
        return on.progress().missing;
    };
    const auto placeAt = [&](double toward_head, int away) {
        const Vec3 to = glm::round(keysToward({0.0, 0.0, toward_head}) * double(away));
        return KeySteps{.right = to.x, .up = to.y, .deeper = deeper + to.z};
    };
    std::vector<KeySteps> places{{.deeper = deeper}};
    training::Refusal missing = press(procedure, places.front());
    for (const double toward_head : {1.0, -1.0}) {
        const auto rib =
            toward_head > 0.0 ? training::Refusal::upperRibNotFelt : training::Refusal::lowerRibNotFelt;
        const auto feels = [&](int away) {
            training::Procedure trial = procedure;
            return press(trial, placeAt(toward_head, away)) != rib;
        };
        for (int away = 1; missing == rib; ++away) {
            if (away > kMaxAway) return {};
            if (!feels(away)) continue;
            // Not on the rib's very edge, if it is wide enough.
            places.push_back(placeAt(toward_head, feels(away + 1) ? away + 1 : away));
            missing = press(procedure, places.back());
        }
    }
    return procedure.progress().step == training::Step::findGap ? std::vector<KeySteps>() : places;
}

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
    bool says(const std::string& text) const {
        return until([&] { return printed().find(text) != std::string::npos; });
    }
    // Waits until the attempt's log contains this event.
    bool happens(const std::string& kind, const std::string& text, std::chrono::seconds most = 120s) const {
        const std::filesystem::path attempt = test::newestAttempt(*command_);
        return until([&] { return test::countOf(attempt, kind, text) > 0; }, most);
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
    // Brings the tool to the place, and on into the skin until it is felt. A stall can turn a motion into a
    // leap, after which a tool on the skin feels nothing until it was lifted. So it begins at Home, again if
    // necessary.
    bool pressAt(Tool tool, const KeySteps& place) {
        for (int tries = 0; tries < 4; ++tries) {
            display_.key("Home");
            for (KeySteps at = place; at.deeper < place.deeper + 14; ++at.deeper) {
                if (!bring(tool, at)) return false;
                if (glm::length(newest_.back().tool_force_n) >= 0.1) return true;
            }
        }
        return false;
    }
    // Repeats `act` until the attempt's log contains this event.
    bool happensBy(const std::function<bool()>& act, const std::string& kind, const std::string& text) const {
        for (int times = 0; times < 6; ++times) {
            if (!act()) return false;
            if (happens(kind, text, 5s)) return true;
        }
        return false;
    }
    std::string where() const {
        if (newest_.empty()) return "nowhere";
        const KeySteps at = stepsNow();
        return std::string(haptics::kToolNames[std::size_t(newest_.back().tool)]) + " at right " +
               std::to_string(at.right) + ", up " + std::to_string(at.up) + ", deeper " +
               std::to_string(at.deeper) + ", rolled " + std::to_string(at.rolled) + ", force " +
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

// Need real time: X events at a real window move every tool and send every command of a whole procedure.
using DesktopRunRealTime = DesktopRun;

// The order and the timing of X events of a real window vary. The test does not depend on the speed of the
// machine.
TEST_F(DesktopRunRealTime, WholeProcedureWithMouseAndKeys) {
    start("--device mouse --scenario procedure --path 2 --trainee mouse-1");
    ASSERT_TRUE(says("you control the ")) << printed();
    ASSERT_TRUE(until([&] { return !display_.title().empty(); }));
    display_.resize(720, 440);  // fewer pixels to draw
    ASSERT_TRUE(until([&] { return readSamples(); })) << printed();
    keys_.emplace(records::loadRecord(record()));
    ASSERT_TRUE(isNear(stepsNow(), {})) << where();

    display_.key("t");  // onto the skin beneath the finger
    ASSERT_TRUE(says("the tool moves to the skin")) << printed();
    ASSERT_TRUE(until([&] { return rests(Tool::finger) && stepsNow().deeper > 10.0; })) << where();
    ASSERT_TRUE(bring(Tool::finger, {})) << where();

    ASSERT_TRUE(bring(Tool::finger, {.deeper = 16})) << where();  // to the skin, then along the skin by mouse
    for (int tries = 0; tries < 12; ++tries) {  // a drag has no effect before the first picture
        display_.drag(250, 130, 270, 130);
        if (until([&] { return readSamples() && stepsNow().right > 1.0; }, 5s)) break;
    }
    EXPECT_GT(stepsNow().right, 1.0) << where();
    display_.key("Home");  // a drag ends between two key steps
    // In a breath-hold, so that the ribs stay where they are.
    display_.key("h");
    ASSERT_TRUE(says("asked for a breath-hold")) << printed();
    ASSERT_TRUE(happens("breath", "held")) << where();
    ASSERT_TRUE(until([&] { return rests(Tool::finger) && newest_.front().breath_held; })) << where();
    const patient::Surrogate breath{newest_.back().breath_v, 0.0, 0.0};
    const std::vector<KeySteps> places = keys_->placesToFeel(breath, 16);
    ASSERT_FALSE(places.empty()) << "no place over a rib";
    for (const KeySteps& place : places)
        ASSERT_TRUE(pressAt(Tool::finger, place)) << where();
    ASSERT_TRUE(happens("step", "find the space between the ribs")) << where();
    display_.key("Home");

    display_.key("p");
    ASSERT_TRUE(says("the probe is in hand")) << printed();
    ASSERT_TRUE(until([&] { return rests(Tool::probe); })) << where();
    const std::optional<KeySteps> on_duct = keys_->probeOnDuct(breath, 16);
    ASSERT_TRUE(on_duct) << "no place of the probe sees the duct";
    ASSERT_TRUE(pressAt(Tool::probe, *on_duct)) << where();
    ASSERT_TRUE(happens("step", "find the duct")) << where();
    display_.key("k");
    ASSERT_TRUE(says("the probe stays where it is")) << printed();
    display_.key("Home");

    display_.key("s");
    ASSERT_TRUE(says("the scalpel is in hand")) << printed();
    ASSERT_TRUE(bring(Tool::scalpel, {.deeper = 17})) << where();
    ASSERT_TRUE(bring(Tool::scalpel, {.up = 3, .deeper = 17})) << where();
    display_.key("Home");
    ASSERT_TRUE(happens("step", "open the skin")) << where();

    display_.key("space");  // next tool
    ASSERT_TRUE(says("the guide is in hand")) << printed();
    const auto along_the_rail = [&] {  // across the rail, which holds the needle, and along it into the skin
        return bring(Tool::guide, {.right = 1}) && bring(Tool::guide, {}) &&
               bring(Tool::guide, {.deeper = 18});
    };
    ASSERT_TRUE(happensBy(along_the_rail, "step", "snap the needle into the guide")) << where();
    display_.key("n");
    ASSERT_TRUE(says("the needle is in hand")) << printed();
    const double target_mm = 30.0 + 1e3 * keys_->path().length_m + 1.0;
    const auto wheel = [&] {
        const int missing = int(std::ceil(target_mm - 1e3 * kKeyStep_m * stepsNow().deeper));
        display_.wheel(250, 130, missing);
        return until([&] { return rests(Tool::needle); });
    };
    ASSERT_TRUE(happensBy(wheel, "step", "advance to the duct")) << where();
    display_.key("x");
    EXPECT_TRUE(says("X-rays")) << printed();
    display_.key("i");
    EXPECT_TRUE(says("contrast medium, 1 ml/s")) << printed();
    ASSERT_TRUE(happens("step", "show the ducts with contrast")) << printed();
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
    for (const auto& [key, name] :
         {std::pair{"F2", "cough"}, {"F4", "bleed"}, {"F5", "move"}, {"F6", "fault"}}) {
        display_.key(key);
        EXPECT_TRUE(says("instructor: " + std::string(name))) << printed();
        EXPECT_TRUE(happens("injected", name)) << printed();
    }
    display_.close();
    const Outcome outcome = outcome_.get();
    test::expectNothingToRearm(outcome);
    const test::KeptAttempt kept = test::checkStoredAttempt(*command_, outcome, "mouse-1");
    test::expectWholeProcedure(kept);
    EXPECT_EQ(kept.stored.info.device, "mouse");
    EXPECT_GT(kept.stored.result->total, 50.0);
    for (const haptics::CommandKind kind : {haptics::CommandKind::cough, haptics::CommandKind::bleed,
                                            haptics::CommandKind::move, haptics::CommandKind::fault})
        EXPECT_EQ(kept.commanded[std::size_t(kind)], 1) << int(kind);
    EXPECT_THAT(kept.page, testing::HasSubstr("too fast")) << "the instructor's comment is on the page";
}

// HZ-TEACH-12
TEST_F(DesktopRunRealTime, AnExamPlacesNoToolAndShowsNoExpert) {
    start("--device mouse --trainee mouse-3 --difficulty exam --scenario '" +
          test::testScenario("short").string() + "'");
    ASSERT_TRUE(says("you control the ")) << printed();
    ASSERT_TRUE(until([&] { return !display_.title().empty() && readSamples(); })) << printed();
    display_.key("t");
    EXPECT_TRUE(says("not placed on the skin: this difficulty does not place tools")) << printed();
    display_.key("o");
    EXPECT_TRUE(says("the expert is shown in guided attempts only")) << printed();
    display_.close();
    EXPECT_EQ(outcome_.get().status, 0);
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
