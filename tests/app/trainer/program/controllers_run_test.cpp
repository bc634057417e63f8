// The procedure with two controllers of a headset. The trainee waits for the effect of each action before the
// next one. The whole procedure runs in virtual time, and its first steps also run through the program in
// real time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <future>
#include <glm/gtc/quaternion.hpp>
#include <thread>

#include "app/records/record.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/session/session.h"
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
constexpr double kAimFromTip_m = 0.15;  // controller_hand.cpp: the tip lies this far ahead of the aim pose

json keyOf(const Pose& p, double t_s) {
    const Quat& q = p.rotation;
    return {{"t_s", t_s},
            {"position", {p.position_m.x, p.position_m.y, p.position_m.z}},
            {"orientation", {q.x, q.y, q.z, q.w}}};
}

// A position relative to the planned path: depth from the skin, offset to the front, and roll.
struct PathPlace {
    double deeper_m = 0.0, front_m = 0.0, roll_rad = 0.0, headward_m = 0.0;
};
constexpr PathPlace kOutside{-0.030};

// Computes the grip pose that puts a tool at a position relative to the path.
class PathAim {
  public:
    PathAim(const Pose& stage_from_patient, const patient::PlannedPath& path)
        : stage_from_patient_(stage_from_patient),
          path_(path),
          axis_(glm::normalize(path.target_m - path.entry_m)) {
        const Vec3 front(0.0, 1.0, 0.0);
        front_ = glm::normalize(front - axis_ * glm::dot(front, axis_));
        const Vec3 head(0.0, 0.0, 1.0);
        headward_ = glm::normalize(head - axis_ * glm::dot(head, axis_));
    }
    double length_m() const { return path_.length_m; }
    Pose grip(Tool tool, const PathPlace& place) const {
        const Vec3 tip_m =
            path_.entry_m + place.deeper_m * axis_ + place.front_m * front_ + place.headward_m * headward_;
        Pose needle = needlePose(tip_m, axis_);
        needle.rotation = needle.rotation * glm::angleAxis(place.roll_rad, Vec3(0.0, 0.0, 1.0));
        const Pose tip = stage_from_patient_ * toolPoseFromNeedle(needle, tool, haptics::GuideSettings{});
        return tip * Pose{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, kAimFromTip_m}};
    }

  private:
    Pose stage_from_patient_;
    patient::PlannedPath path_;
    Vec3 axis_, front_{0.0}, headward_{0.0};
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
    Trainee(const test::Command& command, const std::string& control, const records::RecordInfo& planned)
        : output_(command / "stderr"),
          aim_(stageFromPatient(patient::Patient(patient::loadPackage(planned.patient_folder)),
                                fieldOf(planned.path)),
               planned.path),
          mock_(control, 240s) {
        goTo(aim_.grip(tool_, place_));
        output_.require("controllers: ready", 300s);
        attempt_ = test::newestAttempt(command);
    }

    void waitForOutput(const std::string& words) { output_.require(words); }
    // Waits until the attempt's log contains this event `times` times.
    bool sees(const std::string& kind, const std::string& text,
              std::chrono::seconds patience = kTraineePatience, int times = 1) {
        return test::waitUntil([&] { return test::countOf(attempt_, kind, text) >= times; }, patience, 50);
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
    void goTo(const PathPlace& place, double speed_m_s = 0.04) {
        place_ = place;
        goTo(aim_.grip(tool_, place_), speed_m_s);
    }

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
    PathAim aim_;
    test::MockControl mock_;
    std::filesystem::path attempt_;
    Tool tool_ = Tool::finger;
    PathPlace place_ = kOutside;
    std::optional<Pose> at_;
};

// The same user in virtual time. Each tick reads the controller's driver, and the session runs right after
// it.
class VirtualTrainee {
  public:
    VirtualTrainee(const patient::Patient& patient, const Scenario& scenario,
                   const patient::PlannedPath& path)
        : aim_(stageFromPatient(patient, fieldOf(path)), path),
          attempt_(attemptInTheRoom(patient, scenario, path)),
          simulation_(attempt_.patient, attempt_.simulation, attempt_.touchMap()),
          session_(patient, path, scenario.moments, scenario.approach_distance_m, nullptr),
          at_(aim_.grip(tool_, place_)) {
        port_.attach([this](std::int64_t) { return std::optional(at_); });
        force_.emplace(simulation_.state().output.safety.focused, kDt_s, &live_,
                       [this](const std::string& text) { said_ += text + "\n"; });
        wait(4.0);  // the force ramps up
    }
    const SessionLog& log() const { return session_.log(); }
    double felt_n(Tool tool) const { return felt_n_[std::size_t(tool)]; }
    double length_m() const { return aim_.length_m(); }

    bool sees(const std::string& kind, const std::string& text, double patience_s = 60.0, int times = 1) {
        return until(
            [&] {
                return std::count_if(log().events.begin(), log().events.end(),
                                     [&](const training::SessionEvent& event) {
                                         return event.kind == kind && event.text == text;
                                     }) >= times;
            },
            patience_s);
    }
    void waitForEvent(const std::string& kind, const std::string& text, int times = 1) {
        if (!sees(kind, text, 60.0, times))
            throw std::runtime_error("never happened: " + text + "\n" + said_);
    }
    void waitForOutput(const std::string& words) {
        if (!until([&] { return output_.contains(words); }, 60.0))
            throw std::runtime_error("never printed: " + words + "\n" + said_);
    }
    void hold(const char*, const std::string& key, double value) {
        (key == "trigger/value" ? other_.select : other_squeezes_) = value > 0.5;
        other_.squeeze = other_squeezes_ ? 1.0f : 0.0f;
    }
    void press(const std::string& key, const std::string& until_said) {
        const bool next = key == "b/click";
        next ? void(tool_keys_.menu = true) : void(tool_keys_.squeeze = 1.0f);
        waitForOutput(until_said);
        tool_keys_ = {};
        wait(0.1);
    }
    void turnTo(Tool tool) {
        tool_ = tool;
        goTo(place_);
    }
    void goTo(const PathPlace& place, double speed_m_s = 0.04) {
        place_ = place;
        const GripMotion motion(at_, aim_.grip(tool_, place_), speed_m_s);
        for (double t_s = 0.0; t_s <= motion.seconds; t_s += kDt_s) {
            at_ = motion.at(t_s);
            tick();
        }
    }

  private:
    static constexpr double kDt_s = 0.001;
    static constexpr std::int64_t kDt_ns = 1'000'000;

    class Device : public haptics::HapticDevice {
      public:
        explicit Device(VirtualTrainee& trainee)
            : driver_(trainee.port_, ControllerSide::right,
                      {&trainee, [](void* of) noexcept { return static_cast<VirtualTrainee*>(of)->now_ns_; },
                       [](void*, std::int64_t) noexcept {}}) {}
        const haptics::DeviceProfile& profile() const noexcept override { return driver_.profile(); }
        haptics::DeviceState read(std::int64_t) noexcept override {
            std::string why;
            state_.fresh = 0;
            if (driver_.exchange({}, state_, why) != haptics::DeviceStage::ready) state_.flags = 0;
            return state_;
        }
        void send(const Vec3&) noexcept override {}

      private:
        ControllerDriver driver_;
        haptics::DeviceState state_;
    };

    // Places the controllers in the drawn room.
    static Attempt attemptInTheRoom(const patient::Patient& patient, const Scenario& scenario,
                                    const patient::PlannedPath& path) {
        Attempt attempt = makeLiveAttempt(patient, scenario, path, {.seed = 4},
                                          haptics::makeTouchMap(patient), {.profile = controllerProfile()});
        attempt.simulation.patient_from_device = stageFromPatient(patient, fieldOf(path)).inverse();
        return attempt;
    }
    void tick() {
        port_.publish({Pose{}, std::nullopt, controllerButtons(tool_keys_, other_)});
        haptics::loopTick(simulation_, device_, channels_, stats_, now_ns_);
        session_.drain(channels_);
        force_->update(true, session_, channels_.commands);
        if (const haptics::TickOutput* now = session_.newest()) {
            double& most_n = felt_n_[std::size_t(now->tool)];
            most_n = std::max(most_n, glm::length(now->tool_force.force_n));
        }
        now_ns_ += kDt_ns;
    }
    void wait(double seconds) {
        for (double t_s = 0.0; t_s < seconds; t_s += kDt_s)
            tick();
    }
    bool until(const std::function<bool()>& done, double patience_s) {
        for (double t_s = 0.0; t_s < patience_s; t_s += 0.01) {
            if (done()) return true;
            wait(0.01);
        }
        return done();
    }

    PathAim aim_;
    Tool tool_ = Tool::finger;
    PathPlace place_ = kOutside;
    Attempt attempt_;
    haptics::Simulation simulation_;
    Session session_;
    Pose at_;
    std::int64_t now_ns_ = 0;
    ControllerPort port_;
    Device device_{*this};
    haptics::LoopChannels channels_{kDt_s};
    haptics::LoopStats stats_;
    ControllerKeys tool_keys_, other_;
    bool other_squeezes_ = false;
    LiveHand live_{
        device_,
        [](double) { return false; },
        [] { return std::string(); },
        [](Tool) {},
        {.rearm = 1u << 0, .next = 1u << 1, .breath = 1u << 2, .pedal = 1u << 3, .inject = 1u << 4},
        "the trigger"};
    std::optional<ForceFeed> force_;
    std::array<double, haptics::kToolCount> felt_n_{};
    std::string said_;
    test::ProgramOutput output_{[this] { return said_; }};
};

constexpr const char *kNext = "b/click", *kBreath = "squeeze/value";

void palpate(VirtualTrainee& hand) {
    hand.goTo({0.005});
    hand.goTo({.deeper_m = 0.005, .headward_m = 0.038});  // over the rib above
    hand.goTo({.deeper_m = 0.005, .headward_m = -0.038});
    hand.goTo({0.005});
    hand.waitForEvent("step", "find the space between the ribs");
    hand.goTo(kOutside, 0.08);
}

void findTheDuct(VirtualTrainee& hand) {
    hand.press(kNext, "the probe is in hand");
    hand.turnTo(Tool::probe);
    hand.press(kBreath, "asked for a breath-hold");
    hand.waitForEvent("breath", "held");
    hand.goTo({0.002, 0.0, glm::radians(-35.0)});
    hand.waitForEvent("step", "find the duct");
    hand.press(kNext, "the scalpel is in hand");  // parks the probe
    hand.goTo(kOutside, 0.08);
}

void incise(VirtualTrainee& hand) {
    hand.turnTo(Tool::scalpel);
    hand.goTo({0.005, -0.002});
    hand.goTo({0.005, 0.002}, 0.01);
    hand.goTo(kOutside, 0.08);
    hand.waitForEvent("step", "open the skin");
    hand.press(kBreath, "the patient may breathe");
}

void puncture(VirtualTrainee& hand) {
    hand.press(kNext, "the guide is in hand");
    hand.turnTo(Tool::guide);
    hand.goTo({kOutside.deeper_m, 0.003});  // the guide's rail exerts a force here
    hand.goTo(kOutside);
    hand.press(kNext, "the needle is in hand");
    hand.turnTo(Tool::needle);
    hand.press(kBreath, "asked for a breath-hold");
    hand.waitForEvent("breath", "held", 2);
    hand.goTo({0.7 * hand.length_m()}, 0.02);
    double deeper_m = 0.001;
    hand.goTo({hand.length_m() + deeper_m}, 0.012);
    while (!hand.sees("step", "advance to the duct", 3.0) && deeper_m < 0.004)
        hand.goTo({hand.length_m() + (deeper_m += 0.001)}, 0.012);
    hand.waitForEvent("step", "advance to the duct");
}

// Uses the other controller for pedal and injection.
void showTheDucts(VirtualTrainee& hand) {
    hand.hold("left", "trigger/value", 1.0);
    hand.waitForOutput("X-rays");
    hand.hold("left", "squeeze/value", 1.0);
    hand.waitForOutput("contrast medium, 1 ml/s");
    hand.waitForEvent("step", "show the ducts with contrast");
    hand.hold("left", "squeeze/value", 0.0);
    hand.waitForOutput("no more contrast medium");
    hand.hold("left", "trigger/value", 0.0);
    hand.waitForOutput("no more X-rays");
    hand.goTo(kOutside);
    hand.press(kBreath, "the patient may breathe");
}

TEST(ControllersVirtual, WholeProcedure) {
    test::Command command;
    ASSERT_EQ(command.run("run --fast --spacing-mm 3 --seed 4 --scenario procedure").status, 0);
    const records::RecordInfo planned = records::loadRecord(command.out() / "record").info;
    const patient::Package package = patient::loadPackage(planned.patient_folder);
    const patient::Patient patient(package);
    VirtualTrainee hand(patient, loadScenario(test::assets() / "scenarios" / "procedure.toml"), planned.path);
    palpate(hand);
    findTheDuct(hand);
    incise(hand);
    puncture(hand);
    showTheDucts(hand);

    const SessionLog& log = hand.log();
    EXPECT_EQ(log.progress.steps_done, training::stepsOf(training::Course::puncture));
    EXPECT_EQ(log.progress.out_of_order, 0u);
    EXPECT_TRUE(log.target_hit());
    for (std::size_t tool = 0; tool <= std::size_t(Tool::needle); ++tool)
        EXPECT_GT(hand.felt_n(Tool(tool)), 0.02) << haptics::kToolNames[tool];
    EXPECT_GT(log.score.total, 50.0);
}

// Needs real time: only then do the program, the runtime and a user with two controllers run at the same
// time.
// HZ-TEACH-20
TEST(ControllersRunRealTime, AttemptIsStoredReplayedAndReported) {
    test::Command command;
    const std::string kPatient = " --spacing-mm 3 --seed 4 --scenario procedure ";
    ASSERT_EQ(command.run("run --fast" + kPatient).status, 0);
    const records::RecordInfo planned = records::loadRecord(command.out() / "record").info;

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
        Trainee hand(command, control, planned);
        for (int tries = 0; tries < 10; ++tries) {  // the force may still be ramping up
            hand.goTo({0.005}, 0.1);
            if (hand.sees("contact", "finger on the skin", 2s)) break;
            hand.goTo(kOutside, 0.2);
        }
        hand.waitForEvent("contact", "finger on the skin");
        // A slow machine draws few frames, and the tool may pass a rib between two of them.
        const std::string felt = "find the space between the ribs";
        for (int tries = 0; tries < 10; ++tries) {
            for (const double headward_m : {0.036, -0.036, 0.0})
                hand.goTo({.deeper_m = 0.005, .headward_m = headward_m}, 0.12);
            if (hand.sees("step", felt, 2s)) break;
        }
        hand.waitForEvent("step", felt);
        hand.press(kNext, "the probe is in hand");
        hand.press(kBreath, "asked for a breath-hold");
        hand.hold("left", "trigger/value", 1.0);
        hand.waitForOutput("X-rays");
        hand.hold("left", "squeeze/value", 1.0);
        hand.waitForOutput("contrast medium, 1 ml/s");
        hand.hold("left", "squeeze/value", 0.0);
        hand.waitForOutput("no more contrast medium");
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
    EXPECT_EQ(kept.summary.at("steps").at("out_of_order"), 0);
    EXPECT_GT(kept.felt_n[std::size_t(Tool::finger)], 0.02);
    EXPECT_THAT(outcome.err, testing::HasSubstr("the other hand's trigger is the X-ray pedal"));
    test::expectNothingToRearm(outcome);
}

}  // namespace
}  // namespace stylet::trainer
