// The whole procedure with a headset's two controllers, in real time: somebody who sees what has come of what
// he does, and goes on then.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <future>
#include <glm/gtc/quaternion.hpp>
#include <thread>

#include "app/records/record.h"
#include "app/trainer/hand.h"
#include "app/trainer/staging.h"
#include "tests/app/trainer/kept_attempt.h"
#include "tests/support/mock_control.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;
using haptics::Tool;
using nlohmann::json;
using patient::Pose;
using patient::Quat;
using patient::Vec3;
using test::Outcome;

constexpr auto kPatience = 60s;
constexpr double kAimFromTip_m = 0.15;  // controller_hand.cpp: the tip, ahead of where a controller aims from

json jsonOf(const Pose& p, double t_s) {
    const Quat& q = p.rotation;
    return {{"t_s", t_s},
            {"position", {p.position_m.x, p.position_m.y, p.position_m.z}},
            {"orientation", {q.x, q.y, q.z, q.w}}};
}

// A place on the planned path: from the skin, and beside it.
struct Place {
    double deeper_m = 0.0, front_m = 0.0, roll_rad = 0.0;
};
constexpr Place kOutside{-0.030, 0.0, 0.0};

class Trainee {
  public:
    Trainee(const test::Command& command, const std::string& control, const records::RecordInfo& planned)
        : said_(command / "stderr"),
          path_(planned.path),
          mock_(control, 240s),
          store_(test::storeOf(command)) {
        const patient::Package package = patient::loadPackage(planned.patient_folder);
        stage_from_patient_ = stageFromPatient(patient::Patient(package), path_);
        axis_ = glm::normalize(path_.target_m - path_.entry_m);
        const Vec3 front(0.0, 1.0, 0.0);
        front_ = glm::normalize(front - axis_ * glm::dot(front, axis_));
        goTo(grip());
        if (!hears("controllers: ready", 300s)) throw std::runtime_error(test::textOf(said_));
        attempt_ = test::newestAttempt(command).filename().string();
        std::this_thread::sleep_for(4s);  // the force rises
    }
    double length_m() const { return path_.length_m; }

    // Until the program has said so, after what it was last waited for.
    bool hears(const std::string& words, std::chrono::seconds patience = kPatience) {
        return until(
            [&] {
                const std::string all = test::textOf(said_);
                const std::size_t found = all.find(words, heard_);
                if (found == std::string::npos) return false;
                heard_ = found + words.size();
                return true;
            },
            patience);
    }
    void mustHear(const std::string& words) {
        if (!hears(words)) throw std::runtime_error("never said: " + words + "\n" + test::textOf(said_));
    }
    // Until the attempt's events have it, for the `times`th time.
    bool sees(const std::string& kind, const std::string& text, std::chrono::seconds patience = kPatience,
              int times = 1) {
        return until([&] { return test::countOf(store_.attempt(attempt_), kind, text) >= times; }, patience);
    }
    void mustSee(const std::string& kind, const std::string& text, int times = 1) {
        if (!sees(kind, text, kPatience, times))
            throw std::runtime_error("never happened: " + text + "\n" + test::textOf(said_));
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
        mustHear(until_said);
        set(false);
        std::this_thread::sleep_for(1s);  // until a frame has seen it released
    }
    void turnTo(Tool tool) {
        tool_ = tool;
        goTo(grip());
    }
    // With `speed_m_s` in the middle of the way.
    void goTo(const Place& place, double speed_m_s = 0.04) {
        place_ = place;
        goTo(grip(), speed_m_s);
    }

  private:
    static bool until(const std::function<bool()>& done, std::chrono::seconds patience) {
        for (const auto begin = std::chrono::steady_clock::now(); !done(); std::this_thread::sleep_for(50ms))
            if (std::chrono::steady_clock::now() > begin + patience) return false;
        return true;
    }
    void apply(const char* hand, const json& what) {
        mock_.ask({{"apply", {{"controllers", {{hand, what}}}}}});
    }
    Pose grip() const {
        const Vec3 tip_m = path_.entry_m + place_.deeper_m * axis_ + place_.front_m * front_;
        Pose needle = needlePose(tip_m, axis_);
        needle.rotation = needle.rotation * glm::angleAxis(place_.roll_rad, Vec3(0.0, 0.0, 1.0));
        const Pose tip = stage_from_patient_ * heldLike(needle, tool_, haptics::GuideSettings{});
        return tip * Pose{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, kAimFromTip_m}};
    }
    // From rest to rest, and waits until it is there.
    void goTo(const Pose& to, double speed_m_s = 0.04) {
        const Pose from = at_.value_or(to);
        const double way_m = glm::distance(from.position_m, to.position_m);
        const double angle_rad =
            2.0 * std::acos(std::min(1.0, std::fabs(glm::dot(from.rotation, to.rotation))));
        const double seconds = std::max({0.2, 1.875 * way_m / speed_m_s, angle_rad / 1.5});
        json keys = json::array();
        for (double t_s = 0.0;; t_s += 0.02) {
            const double t = std::min(1.0, t_s / seconds),
                         share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            keys.push_back(jsonOf({glm::slerp(from.rotation, to.rotation, share),
                                   glm::mix(from.position_m, to.position_m, share)},
                                  t_s));
            if (t >= 1.0) break;
        }
        apply("right", {{"poses", keys}});
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds + 0.1));
        at_ = to;
    }

    std::filesystem::path said_;
    patient::PlannedPath path_;
    test::MockControl mock_;
    records::Store store_;
    std::string attempt_;
    Pose stage_from_patient_;
    Vec3 axis_{0.0}, front_{0.0};
    Tool tool_ = Tool::finger;
    Place place_ = kOutside;
    std::optional<Pose> at_;
    std::size_t heard_ = 0;
};

constexpr const char *kNext = "b/click", *kBreath = "squeeze/value";

void palpate(Trainee& hand) {
    hand.goTo({0.005});
    hand.mustSee("step", "find the space between the ribs");
    hand.goTo(kOutside, 0.08);
}

void findTheDuct(Trainee& hand) {
    hand.press(kNext, "the probe is in hand");
    hand.turnTo(Tool::probe);
    hand.press(kBreath, "asked to hold his breath");
    hand.mustSee("breath", "held");
    hand.goTo({0.002, 0.0, glm::radians(-35.0)});
    hand.mustSee("step", "find the duct");
    hand.press(kNext, "the scalpel is in hand");  // and the probe stays where it is
    hand.goTo(kOutside, 0.08);
}

void incise(Trainee& hand) {
    hand.turnTo(Tool::scalpel);
    hand.goTo({0.005, -0.002});
    hand.goTo({0.005, 0.002}, 0.01);
    hand.mustSee("step", "open the skin");
    hand.goTo(kOutside, 0.08);
    hand.press(kBreath, "the patient may breathe");
}

void puncture(Trainee& hand) {
    hand.press(kNext, "the guide is in hand");
    hand.turnTo(Tool::guide);
    hand.mustSee("step", "snap the needle into the guide");
    hand.press(kNext, "the needle is in hand");
    hand.turnTo(Tool::needle);
    hand.press(kBreath, "asked to hold his breath");
    hand.mustSee("breath", "held", 2);
    hand.goTo({0.7 * hand.length_m()}, 0.02);
    double deeper_m = 0.001;
    hand.goTo({hand.length_m() + deeper_m}, 0.012);
    while (!hand.sees("step", "advance to the duct", 3s) && deeper_m < 0.004)
        hand.goTo({hand.length_m() + (deeper_m += 0.001)}, 0.012);
    hand.mustSee("step", "advance to the duct");
}

// With the other hand: the pedal, and the syringe.
void showTheDucts(Trainee& hand) {
    hand.hold("left", "trigger/value", 1.0);
    hand.mustHear("X-rays");
    hand.hold("left", "squeeze/value", 1.0);
    hand.mustHear("contrast medium, 1 ml/s");
    hand.mustSee("step", "show the ducts with contrast");
    hand.hold("left", "squeeze/value", 0.0);
    hand.mustHear("no more contrast medium");
    hand.hold("left", "trigger/value", 0.0);
    hand.mustHear("no more X-rays");
    hand.goTo(kOutside);
    hand.press(kBreath, "the patient may breathe");
}

// HZ-TEACH-20
TEST(ControllersRun, FromPalpationToDuctsFullOfContrast) {
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
        palpate(hand);
        findTheDuct(hand);
        incise(hand);
        puncture(hand);
        showTheDucts(hand);
    } catch (const std::exception& e) {
        ADD_FAILURE() << e.what();
    }
    if (const int process = std::atoi(test::textOf(number).c_str()); process > 0) kill(process, SIGINT);
    const Outcome outcome = run.get();
    command.unset("XRMOCK_SCENARIO");
    command.unset("XRMOCK_CONTROL");

    const test::KeptAttempt kept = test::storedReplayedReported(command, outcome, "hands-1");
    test::expectWholeProcedure(kept);
    EXPECT_EQ(kept.stored.info.device, "controllers");
    EXPECT_GT(kept.stored.result->total, 50.0);
    EXPECT_NE(outcome.err.find("the other hand's trigger is the pedal for X-rays"), std::string::npos);
}

}  // namespace
}  // namespace stylet::trainer
