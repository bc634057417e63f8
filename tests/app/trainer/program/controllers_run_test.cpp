// The first steps of a procedure with two controllers of a headset, through the program in real time. The
// trainee waits for the effect of each action before the next one. hands/whole_course_test.cpp has the rest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <future>
#include <glm/gtc/quaternion.hpp>
#include <thread>

#include "app/records/record.h"
#include "app/records/samples.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/attempt/tool_pose.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/program/kept_attempt.h"
#include "tests/support/mock_control.h"
#include "tests/support/program_output.h"
#include "tests/support/wait_until.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using haptics::Tool;
using nlohmann::json;
using test::Outcome;

constexpr auto kTraineePatience = 60s;
constexpr double kFelt_n = 0.02;
constexpr double kAimFromTip_m = 0.15;  // controller_hand.cpp: the tip lies this far ahead of the aim pose

json keyOf(const Pose& p, double t_s) {
    const Quat& q = p.rotation;
    return {{"t_s", t_s},
            {"position", {p.position_m.x, p.position_m.y, p.position_m.z}},
            {"orientation", {q.x, q.y, q.z, q.w}}};
}

// A position relative to the planned path: depth from the skin, and offset toward the head.
struct PathPlace {
    double deeper_m = 0.0, headward_m = 0.0;
};
constexpr PathPlace kOutside{-0.030};

// Computes the grip pose that puts a tool at a position relative to the path.
class PathAim {
  public:
    PathAim(const Pose& stage_from_patient, const patient::PlannedPath& path)
        : stage_from_patient_(stage_from_patient),
          path_(path),
          axis_(glm::normalize(path.target_m - path.entry_m)) {
        const Vec3 head(0.0, 0.0, 1.0);
        headward_ = glm::normalize(head - axis_ * glm::dot(head, axis_));
    }
    Pose grip(Tool tool, const PathPlace& place) const {
        const Vec3 tip_m = path_.entry_m + place.deeper_m * axis_ + place.headward_m * headward_;
        const Pose tip = stage_from_patient_ *
                         toolPoseFromNeedle(needlePose(tip_m, axis_), tool, haptics::GuideSettings{});
        return tip * Pose{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, kAimFromTip_m}};
    }

  private:
    Pose stage_from_patient_;
    patient::PlannedPath path_;
    Vec3 axis_, headward_{0.0};
};

// A motion that starts and ends at rest and is never faster than `speed_m_s`.
struct GripMotion {
    Pose from, to;
    double seconds;

    GripMotion(const Pose& from_in, const Pose& to_in, double speed_m_s) : from(from_in), to(to_in) {
        const double travel_m = glm::distance(from.position_m, to.position_m);
        const double angle_rad =
            2.0 * std::acos(std::min(1.0, std::fabs(glm::dot(from.rotation, to.rotation))));
        seconds = std::max({0.2, 1.875 * travel_m / speed_m_s, angle_rad / 1.5});
    }
    Pose at(double t_s) const {
        const double t = std::clamp(t_s / seconds, 0.0, 1.0),
                     share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        return {glm::slerp(from.rotation, to.rotation, share),
                glm::mix(from.position_m, to.position_m, share)};
    }
};

class Trainee {
  public:
    Trainee(const test::Command& command, const std::string& control)
        : output_(command / "stderr"), mock_(control, 240s) {
        output_.require("controllers: ready", 300s);
        attempt_ = test::newestAttempt(command);
        test::waitUntil([&] { return std::filesystem::exists(attempt_ / "record" / "record.json"); });
        const records::RecordInfo planned = records::loadRecord(attempt_ / "record").info;
        const patient::Package package = patient::loadPackage(planned.patient_folder);
        aim_.emplace(stageFromPatient(patient::Patient(package), fieldOf(planned.path)), planned.path);
        goTo(kOutside);
    }

    void waitForOutput(const std::string& words) { output_.require(words); }
    // Waits until the attempt's log contains this event `times` times.
    bool sees(const std::string& kind, const std::string& text,
              std::chrono::seconds patience = kTraineePatience, int times = 1) {
        return test::waitUntil([&] { return test::countOf(attempt_, kind, text) >= times; }, patience, 50);
    }
    // Waits until a stored sample has a force of this tool.
    bool feels(Tool tool) {
        return test::waitUntil(
            [&] {
                const std::vector<records::Sample> samples =
                    records::loadSamples(attempt_ / "record").samples;
                return std::any_of(samples.begin(), samples.end(), [&](const records::Sample& sample) {
                    return sample.tool == tool && glm::length(sample.tool_force_n) > kFelt_n;
                });
            },
            2s, 50);
    }
    void waitForEvent(const std::string& kind, const std::string& text, int times = 1) {
        if (!sees(kind, text, kTraineePatience, times))
            throw std::runtime_error("never happened: " + text + "\n" + output_.text());
    }
    void hold(const char* hand, const std::string& key, double value) {
        apply(hand, {{"values", json::array({{{key, value}}})}});
    }
    void press(const std::string& key, const std::string& until_said) {
        const bool click = key.ends_with("click");
        const auto set = [&](bool down) {
            apply("right", {{"values", json::array({{{key, click ? json(down) : json(double(down))}}})}});
        };
        set(true);
        waitForOutput(until_said);
        set(false);
        // Wait until frames have processed the release.
        const int frame = mock_.sendRequest({{"get", "state"}}).at("frame").get<int>();
        mock_.sendRequest({{"wait", {{"frame", frame + 3}}}});
    }
    // Moves with up to `speed_m_s`.
    void goTo(const PathPlace& place, double speed_m_s = 0.04) { goTo(aim_->grip(tool_, place), speed_m_s); }

  private:
    void apply(const char* hand, const json& what) {
        mock_.sendRequest({{"apply", {{"controllers", {{hand, what}}}}}});
    }
    // Moves from rest to rest and waits for the end of the motion.
    void goTo(const Pose& to, double speed_m_s = 0.04) {
        const GripMotion motion(at_.value_or(to), to, speed_m_s);
        json keys = json::array();
        for (double t_s = 0.0;; t_s += 0.02) {
            keys.push_back(keyOf(motion.at(t_s), t_s));
            if (t_s >= motion.seconds) break;
        }
        apply("right", {{"poses", keys}});
        std::this_thread::sleep_for(std::chrono::duration<double>(motion.seconds + 0.1));
        at_ = to;
    }

    test::ProgramOutput output_;
    std::optional<PathAim> aim_;
    test::MockControl mock_;
    std::filesystem::path attempt_;
    Tool tool_ = Tool::finger;
    std::optional<Pose> at_;
};

constexpr const char *kNext = "b/click", *kBreath = "squeeze/value";

// Needs real time: only then do the program, the runtime and a user with two controllers run at the same
// time. What depends on the path between two frames, such as palpation, is tested in virtual time
// (whole_course_test): a slow machine draws few frames.
// HZ-TEACH-20
TEST(ControllersRunRealTime, AttemptIsStoredReplayedAndReported) {
    test::Command command;
    const std::string kPatient = " --spacing-mm 3 --seed 4 --scenario procedure ";
    std::ofstream(command / "scenario.json") << R"({"version": 2, "eyes": {"recommended_size": [64, 64]},
        "head": [{"t_s": 0, "position": [0, 1.5, -0.1], "orientation": [-0.38268343, 0, 0, 0.92387953]}],
        "controllers": {"profile": "/interaction_profiles/valve/index_controller",
                        "left": {"poses": [{"t_s": 0, "position": [-0.3, 1.2, -0.3]}]},
                        "right": {"poses": [{"t_s": 0, "position": [0.3, 1.4, -0.1]}]}}})";
    const std::string control = (command / "control").string(), number = (command / "number").string();
    command.set("XRMOCK_SCENARIO", (command / "scenario.json").string());
    command.set("XRMOCK_CONTROL", control);
    auto run = std::async(std::launch::async, [&] {
        return command.runBare(
            "run --headless --device controllers --seconds 600 --trainee hands-1" + kPatient + "</dev/null",
            "echo $$ >'" + number + "'; exec env ");
    });
    try {
        Trainee hand(command, control);
        for (int tries = 0; tries < 10; ++tries) {  // the force may still be ramping up
            hand.goTo({0.005}, 0.1);
            if (hand.sees("contact", "finger on the skin", 2s) && hand.feels(Tool::finger)) break;
            hand.goTo(kOutside, 0.2);
        }
        hand.waitForEvent("contact", "finger on the skin");
        hand.press(kNext, "the probe is in hand");
        hand.press(kBreath, "asked for a breath-hold");
        hand.hold("left", "trigger/value", 1.0);
        hand.waitForOutput("X-rays");
        hand.hold("left", "squeeze/value", 1.0);
        hand.waitForOutput("contrast medium needs a needle in the body");
        hand.hold("left", "squeeze/value", 0.0);
        hand.hold("left", "trigger/value", 0.0);
        hand.waitForOutput("no more X-rays");
    } catch (const std::exception& e) {
        ADD_FAILURE() << e.what();
    }
    test::signalProgram(number);
    const Outcome outcome = run.get();
    command.unset("XRMOCK_SCENARIO");
    command.unset("XRMOCK_CONTROL");

    const test::KeptAttempt kept = test::checkStoredAttempt(command, outcome, "hands-1");
    EXPECT_EQ(kept.stored.info.device, "controllers");
    EXPECT_THAT(kept.page, testing::HasSubstr("controllers"));
    EXPECT_GT(kept.felt_n[std::size_t(Tool::finger)], kFelt_n);
    EXPECT_THAT(outcome.err, testing::HasSubstr("the other hand's trigger is the X-ray pedal"));
    test::expectNothingToRearm(outcome);
}

}  // namespace
}  // namespace stylet::trainer
