// The whole puncture and the whole drainage with an emulated force device: a Touch behind the bridge's
// protocol. Driver, device thread's work, loop, session and store are the program's own. In virtual time:
// each tick exchanges once with the emulator, so the result does not depend on the speed of the machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/records/replay.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/program/results.h"
#include "app/trainer/session/attempt_writer.h"
#include "app/trainer/session/session_recorder.h"
#include "haptics/devices/bridge/bridge.h"
#include "haptics/devices/polled.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/assets.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using haptics::Tool;

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kRamp_s = 4.0;  // at rest, until the force has risen
constexpr std::uint64_t kSeed = 4;
constexpr double kPeak_n = 3.3;                           // of the emulated device
const Pose kRest{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.1}};  // of the stylus before the procedure, device frame

std::array<double, 7> numbersOf(const Pose& p) {
    const Quat& q = p.rotation;
    return {p.position_m.x, p.position_m.y, p.position_m.z, q.w, q.x, q.y, q.z};
}

patient::Package drawnPatient() {
    patient::synth::SynthSettings settings;
    settings.seed = kSeed;
    settings.spacing_m = 0.0025;
    settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
    return patient::synth::makeReferencePatient(settings);
}

// The parameter is the course.
class ForceDevice : public testing::TestWithParam<training::Course> {
  protected:
    ForceDevice() {
        server_.follow([](std::int64_t) { return numbersOf(kRest); });
        for (int tries = 0; tries < 100 && device_.stage() != haptics::DeviceStage::ready; ++tries)
            poll();
    }
    void poll() {
        time_.now_ns += kTick_ns;
        device_.poll();
    }
    // Of the expert's hand, in the device's frame.
    Pose stylusAt(std::int64_t now_ns) const {
        const std::int64_t index = std::clamp<std::int64_t>((now_ns - begins_ns_) / kTick_ns, 0,
                                                            std::int64_t(expert_->hand.samples.size()) - 1);
        return device_from_expert_ * expert_->hand.samples[std::size_t(index)].device_from_stylus;
    }

    const patient::Package package_ = drawnPatient();
    const patient::Patient patient_{package_};
    const bool drains_ = GetParam() == training::Course::drainage;
    const std::vector<patient::PlannedPath> paths_ = patient::planPaths(patient_, {}).paths;
    const patient::PlannedPath path_ =
        drains_ ? pathForWire(patient::makeDuctSpace(patient_), paths_) : paths_.front();
    const Scenario scenario_ = [this] {
        Scenario scenario =
            loadScenario(test::assets() / "scenarios" / (drains_ ? "drainage.toml" : "procedure.toml"));
        drawCase(scenario, kSeed);
        return scenario;
    }();
    test::TempFolder folder_;
    test::SteppedClock time_;
    std::optional<Attempt> expert_;
    Pose device_from_expert_;
    std::int64_t begins_ns_ = 0;
    test::BridgeServer server_{
        folder_ / "bridge.sock",
        {.force_peak_n = kPeak_n, .workspace_radius_m = 0.3, .time_ns = &time_.now_ns}};
    haptics::PolledDevice device_{
        std::make_unique<haptics::BridgeDriver>(
            time_.clock(), haptics::BridgeSettings{.socket_path = folder_ / "bridge.sock"}),
        time_.clock()};
};

TEST_P(ForceDevice, WholeCourseIsScoredStoredAndReplayedBitByBit) {
    ASSERT_EQ(device_.stage(), haptics::DeviceStage::ready) << device_.report().why;
    ASSERT_FALSE(haptics::isInputOnly(device_.profile()));
    AttemptConfig config;
    config.difficulty = training::Difficulty::exam;  // the device is placed around flank and liver
    config.seed = kSeed;
    haptics::TouchMap touch = haptics::makeTouchMap(patient_);
    const Attempt attempt = makeLiveAttempt(patient_, scenario_, path_, flankField(patient_), config, touch,
                                            {.profile = device_.profile(), .device_from_grip = kRest});
    expert_.emplace(makeAttempt(patient_, scenario_, path_, config.seed, 1000.0,
                                [&](const patient::Patient&) { return touch; }));
    device_from_expert_ =
        attempt.simulation.patient_from_device.inverse() * expert_->simulation.patient_from_device;

    AttemptWriter store(folder_ / "store", "", [](const std::string&) {});
    const records::StoredAttempt begun = store.begin({.trainee = "force-1",
                                                      .device = "bridge",
                                                      .patient = package_.name,
                                                      .scenario = scenario_.name,
                                                      .difficulty = "practice",
                                                      .program_version = STYLET_VERSION,
                                                      .patient_digest = patient::digest(package_),
                                                      .seed = config.seed,
                                                      .dt_s = attempt.simulation.dt_s});
    records::RecordInfo info;
    info.id = begun.id, info.trainee = begun.info.trainee, info.started_utc = begun.started_utc;
    info.device = "bridge", info.clock = "virtual", info.difficulty = "practice";
    info.patient_name = package_.name, info.scenario = scenario_.name, info.seed = config.seed;
    info.course = training::kCourseNames[std::size_t(scenario_.course)], info.path = path_;
    if (drains_) info.patient_case = scenario_.patient_case->toml;
    const std::filesystem::path record_folder = begun.folder / "record";
    records::RecordWriter record(record_folder,
                                 {patient::digest(package_), attempt.simulation, config.instruments}, info);
    SessionRecorder recorder(record_folder, {patient::digest(package_), attempt.simulation.dt_s}, record);
    Session session(patient_, path_, {}, 0.0, &record, attempt.simulation.dt_s);
    session.setDifficulty(training::Difficulty::practice);
    session.setCourse(scenario_.course);
    session.setCase(scenario_.patient_case);
    session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
        recorder.update(now, log);
        store.keep();
    });

    haptics::Simulation simulation(patient_, attempt.simulation, attempt.touchMap(), attempt.ductSpace());
    haptics::LoopChannels channels(attempt.simulation.dt_s);
    LoopTotals totals;
    ForceFeed feed(simulation.state().output.safety.focused, attempt.simulation.dt_s);
    std::array<double, haptics::kToolCount> motor_n{};
    begins_ns_ = time_.now_ns + std::int64_t(kRamp_s * 1e9);
    // Only now, because the server's thread reads what was set up above.
    server_.follow([this](std::int64_t now_ns) { return numbersOf(stylusAt(now_ns)); });
    const std::vector<haptics::TraceCommand>& commands = expert_->hand.commands;
    std::size_t next = 0;
    const std::int64_t ends_ns = begins_ns_ + expert_->hand.samples.back().t_ns;
    while (time_.now_ns < ends_ns) {
        poll();
        for (; next < commands.size() && commands[next].t_ns <= time_.now_ns - begins_ns_; ++next)
            ASSERT_TRUE(channels.commands.push(commands[next].command));
        haptics::loopTick(simulation, device_, channels, totals.haptics, time_.now_ns);
        session.drain(channels);
        feed.update(true, session, channels.commands);
        double& most_n = motor_n[std::size_t(session.newest()->tool)];
        most_n = std::max(most_n, server_.motor_n());
    }
    session.drain(channels);

    const SessionLog& log = session.log();
    EXPECT_EQ(log.progress.steps_done, training::stepsOf(scenario_.course))
        << training::refusalText(log.progress.refusal);
    EXPECT_EQ(log.progress.out_of_order, 0u);
    EXPECT_TRUE(log.target_hit());
    EXPECT_GT(log.score.total, 85.0);
    EXPECT_EQ(log.faults & ~std::uint32_t(haptics::kFaultNotFocused), 0u);
    const Tool last = drains_ ? Tool::drain : Tool::needle;
    for (std::size_t tool = 0; tool <= std::size_t(last); ++tool) {
        // The expert's hand leaves the guide's rail little to push.
        EXPECT_GT(motor_n[tool], Tool(tool) == Tool::guide ? 0.002 : 0.05)
            << "the motors pushed nothing: " << haptics::kToolNames[tool];
        EXPECT_LE(motor_n[tool], kPeak_n);
    }

    recorder.finish(log, makeResult(patient_, log, totals, false));
    const std::string id = store.finish();
    const records::StoredAttempt kept = records::Store(folder_ / "store").attempt(id);
    EXPECT_EQ(kept.state, records::AttemptState::done);
    ASSERT_TRUE(kept.result);
    EXPECT_EQ(kept.result->total, log.score.total);
    EXPECT_EQ(kept.info.device, "bridge");
    const records::ReplayResult again =
        records::replay(patient_, records::loadRecord(kept.folder / "record"), {});
    EXPECT_TRUE(again.equal());
    EXPECT_EQ(again.ticks, log.ticks);
    EXPECT_EQ(again.state_hash, log.state_hash);
}
INSTANTIATE_TEST_SUITE_P(, ForceDevice,
                         testing::Values(training::Course::puncture, training::Course::drainage),
                         [](const auto& of) {
                             return std::string(training::kCourseNames[std::size_t(of.param)]);
                         });

}  // namespace
}  // namespace stylet::trainer
