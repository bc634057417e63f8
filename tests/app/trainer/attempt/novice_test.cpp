// A novice who knows nothing but the tutor's prompts: types or presses what a prompt names, and moves the
// hand as it says. Starts where a guided attempt with the mouse starts. Closes the loop from prompt to
// evidence.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <tuple>
#include <utility>

#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/session/session.h"
#include "app/training/tutor.h"
#include "haptics/devices/clutch.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/attempt/novice_inputs.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/constants.h"
#include "tests/support/seed.h"

namespace stylet::trainer {
namespace {

using haptics::TickOutput;
using haptics::Tool;
using training::Act;

constexpr double kMove_m_s = 0.020, kAside_m_s = 0.015, kTurn_rad_s = 0.25, kSway_s = 3.0;
constexpr double kOffSkin_m = -0.030, kPress_n = 0.3;

class Novice {
  public:
    Novice(const patient::Patient& patient, const patient::PlannedPath& path,
           const haptics::GuideSettings& guide, test::NoviceInput& input)
        : input_(input),
          motion_(patient.package().motion),
          path_(path),
          guide_(guide),
          axis_(glm::normalize(path.target_m - path.entry_m)) {
        const Vec3 head(0.0, 0.0, 1.0);
        headward_ = glm::normalize(head - axis_ * glm::dot(head, axis_));
        frontward_ = glm::normalize(glm::cross(headward_, axis_));
    }

    // Moves on for one tick. The novice presses or types only while the hand is still.
    void follow(Act act, const std::string& prompt, const TickOutput& now) {
        since_s_ += test::kDt_s, again_in_s_ -= test::kDt_s;
        if (std::exchange(act_, act) != act) since_s_ = again_in_s_ = 0.0, cut_phase_ = 0;
        const auto place = [this] { return std::array{deeper_m_, headward_m_, frontward_m_, roll_rad_}; };
        const std::array before = place();
        moveFor(act, prompt, now);
        if (place() == before && again_in_s_ <= 0.0) again_in_s_ = input_.obey(prompt);
    }
    // Reads the case before each question.
    void read(int question) {
        constexpr double kRead_s = 1.0;
        if (std::exchange(question_, question) != question) act_ = Act::answer, again_in_s_ = kRead_s;
    }
    Pose patientFromStylus(Tool tool) {
        held_ = haptics::moveToward(held_, toolPoseFromNeedle({}, tool, guide_), test::kDt_s);
        const Vec3 tip =
            path_.entry_m + axis_ * deeper_m_ + headward_ * headward_m_ + frontward_ * frontward_m_;
        Pose needle = needlePose(tip, axis_);
        needle.rotation =
            needle.rotation * Quat{std::cos(0.5 * roll_rad_), 0.0, 0.0, std::sin(0.5 * roll_rad_)};
        return needle * held_;
    }

  private:
    static void toward(double& value, double goal, double speed) {
        const double step = speed * test::kDt_s;
        value = std::fabs(goal - value) <= step ? goal : value + std::copysign(step, goal - value);
    }
    // Along the tool, as the prompt says: 1 into the body, -1 back, 0 neither.
    double directionIn(const std::string& prompt) const {
        if (prompt.find(input_.facts.pull) != std::string::npos) return -1.0;
        return prompt.find(input_.facts.push) != std::string::npos ? 1.0 : 0.0;
    }
    // To the end of a tool's travel.
    void travel(double direction, double speed) {
        if (direction != 0.0) toward(deeper_m_, direction > 0.0 ? 0.200 : kOffSkin_m, speed);
    }
    void moveFor(Act act, const std::string& prompt, const TickOutput& now) {
        const double direction = directionIn(prompt);
        switch (act) {
            case Act::liftOff:
            case Act::selectFinger:
            case Act::selectProbe:
            case Act::selectScalpel:
            case Act::selectGuide:
            case Act::selectSyringe:
            case Act::liftProbe:
            case Act::withdrawNumbingNeedle:
            case Act::withdrawToRetry:
            case Act::finish:
                toward(deeper_m_, kOffSkin_m, 2.0 * kMove_m_s);
                toward(headward_m_, aim_headward_m_, kAside_m_s);
                toward(frontward_m_, aim_frontward_m_, kAside_m_s);
                toward(roll_rad_, 0.0, kTurn_rad_s);
                break;
            case Act::pressGap:
                press(now, 0.0);
                break;
            case Act::pressUpperRib:
                press(now, 0.040);
                break;
            case Act::pressLowerRib:
                press(now, -0.040);
                break;
            case Act::placeProbe:
                toward(roll_rad_, seen_roll_rad_, kTurn_rad_s);
                if (roll_rad_ == seen_roll_rad_) touchLightly(now);
                break;
            case Act::turnProbe:
                touchLightly(now);
                sweep();
                break;
            case Act::shiftProbe:
                toward(headward_m_, 0.0, kAside_m_s);
                break;
            case Act::aimGuide:
                touchLightly(now);
                aim(now);
                break;
            case Act::cut:
                cut(now);
                break;
            case Act::snapNeedle:
                layIntoGuide(now);
                break;
            case Act::enterSkin:
            case Act::advance:
                travel(direction, 0.5 * kMove_m_s);
                break;
            case Act::enterWheal:
            case Act::pushToCapsule:
                travel(direction, 0.3 * kMove_m_s);
                break;
            case Act::pullNeedleBack:
            case Act::seekDuct:
                travel(direction, 0.2 * kMove_m_s);
                break;
            case Act::feedWire:
            case Act::pushDilator:
            case Act::pushDrain:
            case Act::pullWireBack:
            case Act::withdrawNeedle:
            case Act::withdrawDilator:
            case Act::withdrawDrain:
            case Act::withdrawWire:
            case Act::clearDrain:
            case Act::shiftDrainIn:
            case Act::shiftDrainOut:
            case Act::straightenDrain:
                deeper_m_ += direction * (direction > 0.0 ? 1.0 : 2.0) * kMove_m_s * test::kDt_s;
                break;
            default:
                break;  // keeps still
        }
    }
    // Keeps the probe on the skin without pushing the body wall in.
    void touchLightly(const TickOutput& now) {
        if (now.probe_touching_share < 0.4) toward(deeper_m_, 0.020, kMove_m_s);
        if (now.probe_touching_share > 0.7) toward(deeper_m_, kOffSkin_m, 0.1 * kMove_m_s);
    }
    void press(const TickOutput& now, double headward_m) {
        const double force_n = glm::length(now.tool_force.force_n);
        if (force_n < kPress_n) toward(deeper_m_, 0.020, kMove_m_s);
        if (force_n > 4.0 * kPress_n) toward(deeper_m_, kOffSkin_m, kMove_m_s);
        if (force_n > 0.0) toward(headward_m_, headward_m, kAside_m_s);
    }
    // Brings the needle to the rail, which is in view, and moves it across the rail and back.
    void layIntoGuide(const TickOutput& now) {
        const Pose rail = now.patient_from_probe * guide_.probe_from_guide;
        const Vec3 middle = rail * Vec3(0.0, 0.0, 0.5 * guide_.length_m);
        toward(deeper_m_, glm::dot(middle - path_.entry_m, axis_), kMove_m_s);
        const Vec3 tip = path_.entry_m + axis_ * deeper_m_, along = rail.direction({0, 0, 1});
        const Vec3 on_rail = rail.position_m + along * glm::dot(tip - rail.position_m, along);
        const double beside_m = std::fmod(since_s_, kSway_s) < 0.5 * kSway_s ? 0.003 : 0.0;
        toward(headward_m_, glm::dot(on_rail - tip, headward_) + beside_m, 0.5 * kAside_m_s);
        toward(frontward_m_, glm::dot(on_rail - tip, frontward_), 0.5 * kAside_m_s);
    }
    // Sees duct and dashed line in the picture, and shifts the probe across the line.
    void aim(const TickOutput& now) {
        const Vec3 target_m = patient::deformedFromReference(motion_, now.breath, path_.target_reference_m);
        const Vec3 off_m = target_m - path_.entry_m - headward_ * headward_m_ - frontward_ * frontward_m_;
        toward(headward_m_, headward_m_ + glm::dot(off_m, headward_), 0.5 * kAside_m_s);
        toward(frontward_m_, frontward_m_ + glm::dot(off_m, frontward_), 0.5 * kAside_m_s);
        aim_headward_m_ = headward_m_, aim_frontward_m_ = frontward_m_;
    }
    // Turns to one side, then to the other.
    void sweep() {
        toward(roll_rad_, sweep_rad_, kTurn_rad_s);
        seen_roll_rad_ = roll_rad_;
        if (roll_rad_ == sweep_rad_) sweep_rad_ = -sweep_rad_;
    }
    // Pushes until the blade is in the skin, draws it 4 mm along, and lifts it. Tries again if that was
    // refused.
    void cut(const TickOutput& now) {
        const auto at = [](double value, double goal) { return std::fabs(value - goal) < 1e-9; };
        if (cut_phase_ == 0) {
            const double from_m = aim_frontward_m_ - 0.002;
            // Aside above the skin, then down.
            if (!at(frontward_m_, from_m)) toward(deeper_m_, kOffSkin_m, kMove_m_s);
            if (deeper_m_ < 0.5 * kOffSkin_m) toward(frontward_m_, from_m, kAside_m_s);
            if (at(frontward_m_, from_m)) toward(deeper_m_, 0.020, kMove_m_s);
            if (now.cut_incision >= 0) cut_phase_ = 1, cut_to_m_ = deeper_m_ + 0.003;
        } else if (cut_phase_ == 1) {
            toward(deeper_m_, cut_to_m_, kMove_m_s);
            const double to_m = aim_frontward_m_ + 0.002;
            if (at(deeper_m_, cut_to_m_)) toward(frontward_m_, to_m, 0.5 * kAside_m_s);
            if (at(frontward_m_, to_m)) cut_phase_ = 2;
        } else {
            toward(deeper_m_, kOffSkin_m, kMove_m_s);
            if (at(deeper_m_, kOffSkin_m)) cut_phase_ = 0;
        }
    }

    test::NoviceInput& input_;
    const patient::MotionModel& motion_;
    patient::PlannedPath path_;
    haptics::GuideSettings guide_;
    Vec3 axis_, headward_{0.0}, frontward_{0.0};
    double deeper_m_ = kOffSkin_m, headward_m_ = 0.0, frontward_m_ = 0.0, roll_rad_ = 0.0;
    double aim_headward_m_ = 0.0, aim_frontward_m_ = 0.0;  // where the guide's line met the duct
    double sweep_rad_ = -1.2, seen_roll_rad_ = 0.0;        // the second: where no rib hid the duct
    double cut_to_m_ = 0.0;
    double since_s_ = 0.0, again_in_s_ = 0.0;  // of this prompt; until the novice tries again
    int cut_phase_ = 0, question_ = -1;
    Act act_ = Act::finish;
    Pose held_ = toolPoseFromNeedle({}, Tool::needle, guide_);
};

// The device that the novice moves. Its frame is the patient's.
class NoviceDevice final : public haptics::HapticDevice {
  public:
    explicit NoviceDevice(const haptics::DeviceProfile& profile) : profile_(profile) {}
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceState read(std::int64_t) noexcept override { return state; }
    void send(const Vec3&) noexcept override {}

    haptics::DeviceState state;

  private:
    haptics::DeviceProfile profile_;
};

#if defined(STYLET_SANITIZED)
constexpr int kPatients = 1;
constexpr bool kEveryInput = false;
#elif defined(STYLET_LONG_TESTS)
constexpr int kPatients = 24;
constexpr bool kEveryInput = true;
#else
constexpr int kPatients = 4;
constexpr bool kEveryInput = false;
#endif

struct Guided {
    double seconds = 0.0;
    training::Progress progress;
    std::string said;  // the prompts in order
};

// An attempt in which the loops of the program translate what the novice presses.
Guided followThePrompts(const patient::Patient& patient, const patient::PlannedPath& path,
                        const haptics::TouchMap& touch, training::Course course, test::NoviceInput& input,
                        double limit_s) {
    Attempt attempt = makeAttempt(patient, loadScenario(test::assets() / "scenarios" / "procedure.toml"),
                                  path, 1, 1000.0, [&](const patient::Patient&) { return touch; });
    attempt.simulation.patient_from_device = {};
    attempt.simulation.profile = input.facts.profile;
    attempt.simulation.tools.first = Tool::needle;
    const patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    haptics::Simulation simulation(patient, attempt.simulation, attempt.touchMap(), &ducts);
    Session session(patient, path, {}, 0.0, nullptr, attempt.simulation.dt_s);
    session.setCourse(course);
    if (course == training::Course::drainage)
        session.setCase(std::make_shared<const training::PatientCase>(
            training::loadCase(test::assets() / "cases" / "raised-inr.toml")));
    Novice novice(patient, path, attempt.simulation.tools.guide, input);
    NoviceDevice device(input.facts.profile);
    const LiveHand live{device,      [](double) { return false; }, [&] { return input.typed(); },
                        [](Tool) {}, input.facts.functions,        ""};
    ForceFeed feed(simulation.state().output.safety.focused, test::kDt_s, &live, [](const std::string&) {});
    haptics::LoopChannels channels{test::kDt_s};
    haptics::LoopStats stats;
    Guided guided;
    TickOutput now;
    std::string last;
    for (std::int64_t tick = 0; guided.seconds < limit_s; guided.seconds = double(++tick) * test::kDt_s) {
        const FrameState seen = session.frameState(now);
        const Act act = training::nextAct(seen.progress, now, seen.equipment);
        const std::string prompt = training::prompt(act, input.facts.controls);
        if (prompt != last) guided.said += fmt::format("\n  {:6.1f} s  {}", guided.seconds, last = prompt);
        if (act == Act::finish) break;
        // The novice knows the patient's standards, but which key answers only from the prompt's words.
        if (act == Act::answer) {
            const auto question = training::Question(seen.progress.answered);
            const training::Controls& c = input.facts.controls;
            novice.read(seen.progress.answered);
            novice.follow(act, std::string(rightAnswer(*seen.patient_case, question) ? c.yes : c.no), now);
        } else {
            novice.follow(act, prompt, now);
        }
        device.state.device_from_stylus = novice.patientFromStylus(now.tool);
        device.state.buttons = input.buttons();
        haptics::loopTick(simulation, device, channels, stats, tick * test::kTick_ns);
        session.drain(channels);
        feed.update(true, session, channels.commands);
        now = *session.newest();
    }
    guided.progress = session.log().progress;
    // A puncture has no case, and no wrong answers.
    EXPECT_EQ(session.log().score.values[std::size_t(training::MetricId::caseReview)], 0.0);
    return guided;
}

// Number of patients through whom the prompts led in less than four minutes. The first patient is fixed, and
// every input must lead through it. The others are drawn, and are led by one input in turn, or by all.
int patientsLed(training::Course course, int patients) {
    std::mt19937_64 random(test::seed());
    int led = 0;
    for (int n = 0; n < patients; ++n) {
        patient::synth::SynthSettings settings;
        settings.seed = n == 0 ? 1 : 1 + random() % 1'000'000;
        settings.spacing_m = 0.0025;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        const patient::Package package = patient::synth::makeReferencePatient(settings);
        const patient::Patient patient(package);
        const patient::PlanResult plan = patient::planPaths(patient, {});
        const patient::PlannedPath& path = course == training::Course::drainage
                                               ? pathForWire(patient::makeDuctSpace(patient), plan.paths)
                                               : plan.paths.front();
        const haptics::TouchMap touch = haptics::makeTouchMap(patient);
        auto inputs = test::makeNoviceInputs(course);
        if (n > 0 && !kEveryInput) {
            std::swap(inputs.front(), inputs[std::size_t(n) % inputs.size()]);
            inputs.resize(1);
        }
        bool all_done = true;
        for (const auto& input : inputs) {
            const Guided guided = followThePrompts(patient, path, touch, course, *input, 240.0);
            const bool done = guided.progress.step == training::Step::done;
            all_done = all_done && done;
            EXPECT_TRUE(done || n > 0) << input->facts.name;
            EXPECT_EQ(guided.progress.out_of_order, 0u) << input->facts.name;
            if (!done)
                std::puts((guided.said + "\n" + std::string(refusalText(guided.progress.refusal))).c_str());
            std::puts(fmt::format("seed {}, {}: {:.0f} s", settings.seed, input->facts.name, guided.seconds)
                          .c_str());
        }
        led += all_done;
    }
    return led;
}

// The novice's hand is simple: the body of one drawn patient may defeat it.
// HZ-TEACH-12
TEST(Tutor, ItsPromptsAloneLeadThroughThePuncture) {
    EXPECT_GE(patientsLed(training::Course::puncture, kPatients), std::max(1, kPatients * 3 / 4));
}
TEST(Tutor, ItsPromptsAloneLeadThroughTheDrainage) {
    EXPECT_GE(patientsLed(training::Course::drainage, kPatients), std::max(1, kPatients * 3 / 4));
}

// Every hint names the key, button, gesture or word of the input in use.
TEST(Tutor, HintsFitThePlaceOfThePromptAndNameTheControl) {
    for (const training::Controls* c :
         {&training::kMouseControls, &training::kControllerControls, &training::kTypedControls})
        for (int a = 0; a < training::kActCount; ++a) {
            const std::string hint = training::hint(Act(a), *c);
            EXPECT_LE(hint.size(), 80u) << hint;
            const auto names = [&](std::string_view control) {
                return !control.empty() && hint.find(control) != std::string::npos;
            };
            EXPECT_TRUE(hint.empty() || names(c->move) || names(c->push) || names(c->pull) ||
                        names(c->turn) || names(c->skin) || names(c->expert))
                << hint;
        }
}

// Every act has words of its own for every input, and they name the key, button or word.
TEST(Tutor, PromptsDifferAndNameTheControl) {
    for (const training::Controls* controls :
         {&training::kMouseControls, &training::kControllerControls, &training::kTypedControls})
        for (int a = 0; a < training::kActCount; ++a)
            for (int b = 0; b < a; ++b)
                EXPECT_NE(prompt(Act(a), *controls), prompt(Act(b), *controls));
    EXPECT_NE(prompt(Act::selectProbe, training::kMouseControls).find("press P"), std::string::npos);
    EXPECT_NE(prompt(Act::inject, training::kControllerControls).find("other hand"), std::string::npos);
}

// States in which an earlier version asked for what the tools refuse.
TEST(Tutor, NeverAsksForWhatTheToolsRefuse) {
    training::Progress progress;
    progress.course = training::Course::drainage;
    TickOutput now;
    now.tool_awaits_exit = false;
    const auto next = [&](training::Step step) {
        progress.step = step;
        return training::nextAct(progress, now, {});
    };
    now.tool = Tool::needle, now.phase = haptics::Phase::pass, now.depth_m = 0.05;
    now.tissue = patient::Tissue::liver;
    for (const auto step : {training::Step::aspirate, training::Step::contrast, training::Step::wire})
        EXPECT_EQ(next(step), Act::seekDuct) << "the tip has slipped out of the duct";
    now.tissue = patient::Tissue::duct;
    EXPECT_EQ(next(training::Step::aspirate), Act::aspirate);
    EXPECT_EQ(next(training::Step::wire), Act::selectWire);
    // A wire that has just been taken does not yet hold the way for the dilator.
    now.tool = Tool::wire;
    now.access.open = now.access.wire_in = now.access.needle_in = true;
    EXPECT_EQ(next(training::Step::dilate), Act::feedWire);
    now.access.in_duct_m = 0.030;
    EXPECT_EQ(next(training::Step::dilate), Act::selectNeedle);
    now.access.pierced = true;
    EXPECT_EQ(next(training::Step::drain), Act::pullWireBack);
    now.access.pierced = now.access.needle_in = false;
    now.access.drain = haptics::DrainState::misplaced, now.access.drain_m = 0.2;
    EXPECT_EQ(next(training::Step::drain), Act::straightenDrain) << "the wire mends it";
    now.access.open = now.access.wire_in = false;
    EXPECT_EQ(next(training::Step::drain), Act::rewireDrain);
    now.access.open = now.access.wire_in = true;
    EXPECT_EQ(next(training::Step::dilate), Act::selectDrain) << "no dilator fits beside the drain";
    now.tool = Tool::drain;
    EXPECT_EQ(next(training::Step::dilate), Act::withdrawDrain);
    now.tool = Tool::wire;
    // Local anaesthetic flows only where it is wanted.
    now = {};
    now.tool_awaits_exit = false;
    now.tool = Tool::needle, now.phase = haptics::Phase::pass;
    training::Equipment syringe;
    syringe.anaesthetic_m3_per_s = 1e-6;
    progress.step = training::Step::anaesthetise;
    const auto numb = [&](training::Refusal missing, training::TrackPlace at) {
        progress.missing = missing, progress.track_place = at;
        return training::nextAct(progress, now, syringe);
    };
    using training::TrackPlace;
    EXPECT_EQ(numb(training::Refusal::skinNotNumb, TrackPlace::skin), Act::numbSkin);
    EXPECT_EQ(numb(training::Refusal::capsuleNotNumb, TrackPlace::skin), Act::stopInjecting);
    EXPECT_EQ(numb(training::Refusal::capsuleNotNumb, TrackPlace::capsule), Act::numbCapsule);
    syringe = {};
    EXPECT_EQ(numb(training::Refusal::skinNotNumb, TrackPlace::outside), Act::selectProbe)
        << "the parked probe shows the track";
    now.probe_parked = true;
    EXPECT_EQ(numb(training::Refusal::skinNotNumb, TrackPlace::outside), Act::enterWheal);
    EXPECT_EQ(numb(training::Refusal::capsuleNotNumb, TrackPlace::wall), Act::pushToCapsule);
    EXPECT_EQ(numb(training::Refusal::capsuleNotNumb, TrackPlace::beyond), Act::pullNeedleBack);
    EXPECT_EQ(numb(training::Refusal::capsuleNotNumb, TrackPlace::aside), Act::withdrawNumbingNeedle);
    EXPECT_EQ(next(training::Step::incise), Act::withdrawNumbingNeedle) << "the needle is still in the skin";
    // A probe that was parked where it shows nothing.
    progress.missing = training::Refusal::ductBesidePlane;
    now = {};
    now.tool_awaits_exit = false;
    now.tool = Tool::probe, now.probe_parked = now.breath_held = true;
    EXPECT_EQ(next(training::Step::findDuct), Act::liftProbe);
    progress.missing = training::Refusal::ductBesideRail;
    EXPECT_EQ(next(training::Step::incise), Act::liftProbe);
}

// A breath-hold is too short to bring the probe to its place. The prompt to place it has a ring and an arrow.
TEST(Tutor, TheProbeIsPlacedBeforeTheBreathIsHeld) {
    training::Progress progress;
    TickOutput now;
    now.tool_awaits_exit = false;
    now.tool = Tool::probe;
    for (const auto& [step, missing, in_hold] :
         {std::tuple{training::Step::findDuct, training::Refusal::ductBesidePlane, Act::shiftProbe},
          std::tuple{training::Step::incise, training::Refusal::ductBesideRail, Act::aimGuide}}) {
        progress.step = step, progress.missing = missing;
        const auto next = [&](double touching_share, double off_path_m, bool breath_held) {
            now.probe_touching_share = touching_share, now.breath_held = breath_held;
            progress.off_path_m = off_path_m;
            return training::nextAct(progress, now, {});
        };
        EXPECT_EQ(next(0.0, 0.005, false), Act::placeProbe) << "in the air";
        EXPECT_EQ(next(1.0, 0.060, false), Act::placeProbe) << "on the skin beside its place";
        EXPECT_EQ(next(1.0, 0.020, false), Act::holdBreath);
        EXPECT_EQ(next(1.0, 0.020, true), in_hold);
    }
}

// A mouse wheel has two directions, and the key list calls them as the prompts do.
TEST(Tutor, PromptsNameTheDirectionOfTheWheel) {
    const training::Controls& c = training::kMouseControls;
    EXPECT_NE(prompt(Act::advance, c).find("turn the wheel forward or press Page Down"), std::string::npos);
    EXPECT_NE(prompt(Act::withdrawToRetry, c).find("turn the wheel back or press Page Up"),
              std::string::npos);
}

}  // namespace
}  // namespace stylet::trainer
