// The whole puncture and the whole drainage with mouse and keys, and with two controllers. Driver, port,
// keys, buttons, loop and session are the program's own. In virtual time. The user does the stages of the
// expert's scenario: moves the tool, and presses the key or the button for each command.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <map>

#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/hands/snap.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/loops.h"
#include "app/training/infiltration.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/assets.h"
#include "tests/support/constants.h"
#include "tests/support/stepped_clock.h"
#if defined(STYLET_WINDOW)
#include "app/trainer/window/window_keys.h"
#endif

namespace stylet::trainer {
namespace {

using haptics::TickOutput;
using haptics::Tool;
using test::kDt_s;

constexpr Place kBeforeSkin{.deeper_m = -0.030};

// Needle poses along the planned path.
struct PathFrame {
    explicit PathFrame(const patient::Patient& patient, const patient::PlannedPath& path)
        : entry_m(path.entry_m),
          length_m(glm::length(path.target_m - path.entry_m)),
          capsule_m(training::capsuleDepth_m(patient, path)),
          axis((path.target_m - path.entry_m) / length_m) {
        const Vec3 head(0.0, 0.0, 1.0);
        headward = glm::normalize(head - axis * glm::dot(head, axis));
        frontward = glm::normalize(glm::cross(headward, axis));
        if (frontward.y < 0.0) frontward = -frontward;
    }
    // The same place without a share of the path.
    Place resolved(Place place) const {
        place.deeper_m += place.share * (place.to_capsule ? capsule_m : length_m);
        place.share = 0.0;
        return place;
    }
    Vec3 tip_m(const Place& p) const {
        return entry_m + p.deeper_m * axis + p.headward_m * headward + p.frontward_m * frontward;
    }
    Pose needle(const Place& p) const {
        Pose pose = needlePose(tip_m(p), axis);
        pose.rotation =
            pose.rotation * Quat{std::cos(0.5 * p.roll_rad), 0.0, 0.0, std::sin(0.5 * p.roll_rad)};
        return pose;
    }

    Vec3 entry_m;
    double length_m, capsule_m;
    Vec3 axis, headward{0.0}, frontward{0.0};
};

// An input of the program, and the user's fingers on it.
class UserInput {
  public:
    virtual ~UserInput() = default;
    virtual haptics::Driver& driver() = 0;
    virtual UserButtons functions() const = 0;
    virtual Pose patientFromDevice() const { return {}; }
    virtual std::string typed() { return {}; }
    virtual void feel(const TickOutput&) = 0;
    // Moves the hand on to this place within a tick.
    virtual void moveTo(const Place& from, const Place& to, Tool) = 0;
    // Presses what a typed word would command.
    virtual void press(const std::string& word) = 0;
    virtual void release() {}
    // Has the tool placed on the skin at this pose in the patient, and returns it to `kBeforeSkin`.
    virtual void snapTo(const Pose& patient_from_tool) = 0;
    virtual void comeBack() = 0;
};

#if defined(STYLET_WINDOW)
class MouseAndKeys final : public UserInput {
  public:
    MouseAndKeys(const patient::Patient& patient, const PathFrame& frame, const patient::PlannedPath& path,
                 training::Course course, const haptics::Clock& clock)
        : frame_(frame),
          driver_(*port_, mouseStart(training::StartPlace::path, patient, path, 0), {}, clock) {
        port_->enableToolInput();
        keys_.setCourse(course);
    }
    haptics::Driver& driver() override { return driver_; }
    UserButtons functions() const override { return {.rearm = 0}; }
    std::string typed() override { return port_->typed(); }
    void feel(const TickOutput& now) override {
        port_->publish(now.tool, glm::length(now.tool_force.force_n));
    }
    void moveTo(const Place& from, const Place& to, Tool) override {
        port_->move(
            {.moved_m = frame_.tip_m(to) - frame_.tip_m(from), .rolled_rad = to.roll_rad - from.roll_rad});
    }
    void press(const std::string& word) override {
        static const std::map<std::string, char> kKeys{
            {"finger", 'f'},  {"probe", 'p'},    {"park", 'k'},    {"scalpel", 's'}, {"guide", 'g'},
            {"needle", 'n'},  {"wire", 'w'},     {"dilator", 'd'}, {"drain", 'a'},   {"hold", 'h'},
            {"breathe", 'b'}, {"numb", 'm'},     {"inject", 'i'},  {"stop", 'i'},    {"pedal", 'x'},
            {"release", 'x'}, {"aspirate", 'v'}, {"skin", 't'},    {"yes", 'y'},     {"no", 'u'}};
        KeyPress press;
        press.key = kKeys.at(word);
        keys_.press(press);
    }
    void snapTo(const Pose& patient_from_tool) override {
        EXPECT_EQ(requestSnap(patient_from_tool, nullptr, *port_), "");
    }
    void comeBack() override { port_->move({.home = true}); }

  private:
    const PathFrame& frame_;
    std::shared_ptr<WindowPort> port_ = std::make_shared<WindowPort>();
    WindowKeys keys_{port_};
    MouseDriver driver_;
};
#endif

class TwoControllers final : public UserInput {
  public:
    TwoControllers(const patient::Patient& patient, const PathFrame& frame, const patient::PlannedPath& path,
                   const haptics::Clock& clock)
        : frame_(frame),
          room_from_patient_(stageFromPatient(patient, fieldOf(path))),
          driver_(port_, ControllerSide::right, clock) {
        moveTo(kBeforeSkin, kBeforeSkin, Tool::finger);
        port_.attach([this](std::int64_t) { return std::optional(grip_); });
    }
    haptics::Driver& driver() override { return driver_; }
    UserButtons functions() const override { return kControllerFunctions; }
    Pose patientFromDevice() const override { return room_from_patient_.inverse(); }
    void feel(const TickOutput& now) override {
        port_.setTouching(touchesPatient(now));
        port_.publish({Pose{}, std::nullopt, controllerButtons(tool_, other_)});
    }
    void moveTo(const Place&, const Place& to, Tool tool) override {
        constexpr Pose kTipFromGrip{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.15}};  // controller_hand.cpp
        held_ = haptics::moveToward(held_, toolPoseFromNeedle({}, tool, {}), kDt_s);
        grip_ = room_from_patient_ * frame_.needle(to) * held_ * kTipFromGrip;
    }
    // The button for the next tool, which also answers no, is pressed until the tool is in hand.
    void press(const std::string& word) override {
        if (word == "hold" || word == "breathe" || word == "yes")
            tool_.squeeze = 1.0f;
        else if (word == "numb" || word == "inject" || word == "stop")
            other_.squeeze = word == "stop" ? 0.0f : 1.0f;
        else if (word == "pedal" || word == "release")
            other_.select = word == "pedal";
        else if (word == "aspirate")
            other_.menu = true;
        else if (word == "skin")
            tool_.select = true;
        else
            tool_.menu = true;
    }
    void release() override { tool_.menu = other_.menu = false, tool_.squeeze = 0.0f; }
    void snapTo(const Pose& patient_from_tool) override {
        WindowPort none;
        EXPECT_EQ(requestSnap(room_from_patient_ * patient_from_tool, &port_, none), "");
    }
    void comeBack() override { tool_.select = false; }

  private:
    const PathFrame& frame_;
    Pose room_from_patient_, grip_, held_ = toolPoseFromNeedle({}, Tool::finger, {});
    ControllerPort port_;
    ControllerDriver driver_;
    ControllerKeys tool_, other_;
};

// Reads the driver in the tick.
class DriverDevice final : public haptics::HapticDevice {
  public:
    explicit DriverDevice(haptics::Driver& driver) : driver_(driver) {
        std::string why;
        EXPECT_EQ(driver_.open(why), haptics::DeviceStage::ready) << why;
    }
    const haptics::DeviceProfile& profile() const noexcept override { return driver_.profile(); }
    haptics::DeviceState read(std::int64_t) noexcept override {
        std::string why;
        state_.fresh = 0;
        if (driver_.exchange({}, state_, why) != haptics::DeviceStage::ready) state_.flags = 0;
        return state_;
    }
    void send(const Vec3&) noexcept override {}

  private:
    haptics::Driver& driver_;
    haptics::DeviceState state_;
};

class User {
  public:
    User(UserInput& input, test::SteppedClock& time, const PathFrame& frame, const patient::Patient& patient,
         const Scenario& scenario, const patient::PlannedPath& path)
        : input_(input),
          time_(time),
          frame_(frame),
          scenario_(scenario),
          device_(input.driver()),
          attempt_(makeLiveAttempt(patient, scenario, path, fieldOf(path), {.seed = 4},
                                   haptics::makeTouchMap(patient), {.profile = device_.profile()})),
          session_(patient, path, {}, 0.0, nullptr, kDt_s) {
        attempt_.simulation.patient_from_device = input.patientFromDevice();
        simulation_.emplace(patient, attempt_.simulation, attempt_.touchMap(), attempt_.ductSpace());
        session_.setCourse(scenario.course);
        session_.setCase(scenario.patient_case);
        force_.emplace(simulation_->state().output.safety.focused, kDt_s, &live_,
                       [this](const std::string& text) { said += text + "\n"; });
        wait(1.0);
    }
    void play() {
        for (const Stage& stage : scenario_.stages)
            play(stage);
    }
    const SessionLog& log() const { return session_.log(); }

    std::string said;
    std::map<Tool, Vec3> snapped_to;  // where the tools were placed on the skin
    std::map<Tool, double> felt_n;    // largest force of each tool

  private:
    const TickOutput& now() const { return *session_.newest(); }
    void tick() {
        input_.moveTo(at_, next_, now_tool_);
        at_ = next_;
        time_.now_ns += test::kTick_ns;
        haptics::loopTick(*simulation_, device_, channels_, stats_, time_.now_ns);
        session_.drain(channels_);
        force_->update(true, session_, channels_.commands);
        if (!session_.newest()) return;
        now_tool_ = now().tool;
        double& most_n = felt_n[now_tool_];
        most_n = std::max(most_n, glm::length(now().tool_force.force_n));
    }
    void wait(double seconds) {
        for (double t_s = 0.0; t_s < seconds; t_s += kDt_s)
            tick();
    }
    template <typename Done>
    void until(Done&& done, const char* what) {
        for (double t_s = 0.0; t_s < 20.0 && !done(); t_s += kDt_s)
            tick();
        EXPECT_TRUE(done()) << "never: " << what << "\n" << said;
    }
    void press(const std::string& word) {
        input_.press(word);
        wait(0.1);
        input_.release();
        wait(0.1);
    }
    // From rest to rest.
    void moveTo(const Place& place, double speed_m_s) {
        const Place from = at_, to = frame_.resolved(place);
        const double seconds =
            std::max(0.2, 1.875 * glm::distance(frame_.tip_m(from), frame_.tip_m(to)) / speed_m_s);
        for (double t_s = kDt_s; t_s < seconds + kDt_s; t_s += kDt_s) {
            const double t = std::min(1.0, t_s / seconds),
                         share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            const auto between = [share](double a, double b) { return a + share * (b - a); };
            next_ = {.deeper_m = between(from.deeper_m, to.deeper_m),
                     .headward_m = between(from.headward_m, to.headward_m),
                     .frontward_m = between(from.frontward_m, to.frontward_m),
                     .roll_rad = between(from.roll_rad, to.roll_rad)};
            tick();
        }
        next_ = to;
        wait(0.3);  // the mouse's tool follows smoothly
    }
    void changeTool(Tool tool) {
        const auto in_hand = [&] { return now().tool == tool; };
        for (int presses = 0; presses < haptics::kToolCount && !in_hand(); ++presses)
            press(std::string(haptics::kToolNames[std::size_t(tool)]));
        EXPECT_TRUE(in_hand()) << haptics::kToolNames[std::size_t(tool)] << "\n" << said;
    }
    // Snap to skin, and back. A free needle and the scalpel stop in front of the skin; a tool that touches
    // something would not come back to a controller whose hand is still.
    void touchSkin() {
        const Tool tool = now().tool;
        const bool touches_nothing =
            tool == Tool::scalpel || (tool == Tool::needle && !now().needle_in_guide);
        if (at_ != kBeforeSkin || !touches_nothing || snapped_to.contains(tool)) return;
        input_.press("skin");
        wait(1.5);
        snapped_to[tool] = now().patient_from_tool.position_m;
        input_.comeBack();
        wait(1.5);
    }
    void play(const Stage& stage) {
        switch (stage.kind) {
            case StageKind::wait:
                return wait(stage.seconds);
            case StageKind::move:
                return moveTo(stage.to, stage.speed_m_s);
            case StageKind::hold:
                press("hold");
                return until([&] { return now().breath_held; }, "a breath-hold");
            case StageKind::breathe:
                press("breathe");
                return until([&] { return !now().breath_held; }, "a breath");
            case StageKind::changeTool:
                changeTool(stage.tool);
                wait(stage.seconds);
                return touchSkin();
            case StageKind::park:
                press("park");
                return until([&] { return now().probe_parked; }, "the probe is parked");
            case StageKind::aspirate:
                return press("aspirate");
            case StageKind::inject:
            case StageKind::numb:
                input_.press(stage.kind == StageKind::numb ? "numb" : "inject");
                wait(stage.seconds);
                return press("stop");
            case StageKind::pedal:
                return press(stage.pedal_down ? "pedal" : "release");
            case StageKind::review:
                return review();
            case StageKind::lift:
            case StageKind::machine:
                return;  // the equipment's knobs stay as they are
        }
    }
    void review() {
        if (!scenario_.patient_case) return;
        for (int i = 0; i < training::kQuestionCount; ++i) {
            wait(UserCommands::kReadQuestion_s);
            press(training::rightAnswer(*scenario_.patient_case, training::Question(i)) ? "yes" : "no");
            until([&] { return log().progress.answered > i; }, "an answer");
        }
    }
    std::string snap(const TickOutput& now) {
        std::string why_not;
        const auto pose = poseOnSkin({.snap = true}, now, attempt_.patient, *attempt_.touchMap(), why_not);
        if (pose) input_.snapTo(*pose);
        return why_not;
    }

    UserInput& input_;
    test::SteppedClock& time_;
    const PathFrame& frame_;
    const Scenario& scenario_;
    DriverDevice device_;
    Attempt attempt_;
    Session session_;
    std::optional<haptics::Simulation> simulation_;
    haptics::LoopChannels channels_{kDt_s};
    haptics::LoopStats stats_;
    LiveHand live_{.device = device_,
                   .over = [](double) { return false; },
                   .typed = [this] { return input_.typed(); },
                   .set_tool = [](Tool) {},
                   .buttons = input_.functions(),
                   .rearm_act = "",
                   .felt = [this](const TickOutput& now) { input_.feel(now); },
                   .snap = [this](const TickOutput& now) { return snap(now); }};
    std::optional<ForceFeed> force_;
    Place at_ = kBeforeSkin, next_ = kBeforeSkin;
    Tool now_tool_ = Tool::finger;
};

// Without the window there are no mouse and keys.
#if defined(STYLET_WINDOW)
const auto kWithControllers = testing::Bool();
#else
const auto kWithControllers = testing::Values(true);
#endif

// The parameters are the course, and whether the user has controllers.
class WholeCourse : public testing::TestWithParam<std::tuple<training::Course, bool>> {};

TEST_P(WholeCourse, IsDoneAndScored) {
    const auto [course, controllers] = GetParam();
    const bool drains = course == training::Course::drainage;
    patient::synth::SynthSettings settings;
    settings.seed = 4;
    settings.spacing_m = 0.0025;
    settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
    const patient::Package package = patient::synth::makeReferencePatient(settings);
    const patient::Patient patient(package);
    const std::vector<patient::PlannedPath> paths = patient::planPaths(patient, {}).paths;
    const patient::PlannedPath path =
        drains ? pathForWire(patient::makeDuctSpace(patient), paths) : paths.front();
    const PathFrame frame(patient, path);
    Scenario scenario =
        loadScenario(test::assets() / "scenarios" / (drains ? "drainage.toml" : "procedure.toml"));
    drawCase(scenario, settings.seed);
    test::SteppedClock time;
    std::unique_ptr<UserInput> input;
    if (controllers) input = std::make_unique<TwoControllers>(patient, frame, path, time.clock());
#if defined(STYLET_WINDOW)
    else
        input = std::make_unique<MouseAndKeys>(patient, frame, path, course, time.clock());
#endif
    User user(*input, time, frame, patient, scenario, path);
    user.play();

    const training::Progress& progress = user.log().progress;
    EXPECT_EQ(progress.steps_done, training::stepsOf(course))
        << training::stepName(progress.step) << ": " << training::refusalText(progress.refusal) << "\n"
        << user.said;
    EXPECT_EQ(progress.out_of_order, 0u);
    EXPECT_TRUE(user.log().target_hit());
    EXPECT_GT(user.log().score.total, 80.0);
    EXPECT_TRUE(training::passesExam(progress));
    const Tool last = drains ? Tool::drain : Tool::needle;
    for (int tool = 0; tool <= int(last); ++tool)
        EXPECT_GT(user.felt_n[Tool(tool)], 0.02) << haptics::kToolNames[std::size_t(tool)];
    EXPECT_EQ(user.snapped_to.size(), drains ? 2u : 1u);
    for (const auto& [tool, at_m] : user.snapped_to)
        EXPECT_LT(glm::distance(at_m, frame.entry_m), 0.015) << haptics::kToolNames[std::size_t(tool)];
}
INSTANTIATE_TEST_SUITE_P(, WholeCourse,
                         testing::Combine(testing::Values(training::Course::puncture,
                                                          training::Course::drainage),
                                          kWithControllers),
                         [](const auto& of) {
                             return std::string(training::kCourseNames[std::size_t(std::get<0>(of.param))]) +
                                    (std::get<1>(of.param) ? "WithControllers" : "WithMouseAndKeys");
                         });

}  // namespace
}  // namespace stylet::trainer
