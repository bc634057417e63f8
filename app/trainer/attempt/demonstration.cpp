#include "app/trainer/attempt/demonstration.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/installation.h"
#include "app/trainer/session/session.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using haptics::TickOutput;
using training::Step;

namespace {

constexpr std::uint64_t kExpertSeed = 1;

// Pose of the tool that a picture of the expert shows.
Pose shownPose(const TickOutput& now) {
    return haptics::isNeedleTool(now.tool) ? now.patient_from_needle : now.patient_from_tool;
}

}  // namespace

Demonstration::Demonstration(const patient::Patient& patient, const patient::PlannedPath& path,
                             training::Course course, const MakeTouch& make_touch)
    : motion_(&patient.package().motion) {
    const char* name = course == training::Course::drainage ? "drainage" : "procedure";
    const Scenario scenario = loadScenario(scenarioFile(name));
    const Attempt attempt = makeAttempt(patient, scenario, path, kExpertSeed, 1000.0, make_touch);
    haptics::Simulation simulation(patient, attempt.simulation, attempt.touchMap(), attempt.ductSpace());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    Session session(patient, path, {}, 0.0, nullptr, attempt.simulation.dt_s);
    session.setCourse(course);
    const auto dt_ns = std::llround(attempt.simulation.dt_s * 1e9),
               every = std::llround(kSample_s * 1e9) / dt_ns;
    const std::int64_t ticks = attempt.hand.samples.back().t_ns / dt_ns;
    std::size_t next = 0;
    TickOutput now;
    for (std::int64_t tick = 0; tick <= ticks; ++tick) {
        haptics::TickInput input;
        input.device = device.read(tick * dt_ns);
        for (; next < attempt.hand.commands.size() && attempt.hand.commands[next].t_ns <= tick * dt_ns;
             ++next)
            input.add(attempt.hand.commands[next].command);
        haptics::NeedleEvents events;
        simulation.step(input, now, events);
        session.update(input, now, events);
        const Step step = session.log().progress.step;
        if (step == Step::done) break;
        if (tick % every != 0) continue;
        const Pose pose = shownPose(now);
        samples_[std::size_t(step)].push_back(
            {now.tool, pose, patient::referenceFromDeformed(*motion_, now.breath, pose.position_m),
             accesses_.size()});
        // Wire, dilator and drain follow their track, not the hand's pose.
        if (haptics::isAccessTool(now.tool)) accesses_.push_back(now.access);
    }
    // On a few paths the script does not succeed in a step, and what follows was recorded as that step.
    steps_done_ = session.log().progress.steps_done;
    for (std::size_t step = 0; step < samples_.size(); ++step)
        if (!training::contains(steps_done_, Step(step))) samples_[step].clear();
}

std::string Demonstration::describeMissing(Step step) const {
    if (step == Step::done) return "the expert has nothing more to show: all steps are done";
    const std::string_view name = training::stepName(step);
    if (step == Step::reviewCase) return fmt::format("the expert cannot show \"{}\": it needs no tool", name);
    if (!training::contains(steps_done_, step))
        return fmt::format("the expert cannot show \"{}\": the script does not complete it on this path",
                           name);
    if (samples_[std::size_t(step)].empty())
        return fmt::format("the expert cannot show \"{}\": the script completes it within another step",
                           name);
    return "";
}

double Demonstration::length_s(Step step) const {
    return step == Step::done ? 0.0 : kSample_s * double(samples_[std::size_t(step)].size());
}

std::optional<GhostTool> Demonstration::at(Step step, double t_s, const patient::Surrogate& breath) const {
    if (!(length_s(step) > 0.0)) return std::nullopt;
    const std::vector<Sample>& samples = samples_[std::size_t(step)];
    const double in_loop_s = std::fmod(std::max(0.0, t_s), length_s(step) + kRest_s);
    const Sample& sample = samples[std::min(std::size_t(in_loop_s / kSample_s), samples.size() - 1)];
    GhostTool ghost{.tool = sample.tool, .patient_from_tool = sample.patient_from_tool};
    if (haptics::isAccessTool(sample.tool)) ghost.access = accesses_[sample.access];
    ghost.patient_from_tool.position_m =
        patient::deformedFromReference(*motion_, breath, sample.tip_reference_m);
    return ghost;
}

std::string ExpertBeside::toggle(const training::DifficultyRules& rules) {
    if (!rules.expert) return "the expert is shown in guided attempts only";
    shown_ = !shown_;
    if (!shown_) return "the expert is no longer shown";
    step_.reset();
    if (made_ || future_.valid()) return "the expert does each step beside you";
    future_ = std::async(std::launch::async, make_);
    return "the expert does each step beside you, in a moment";
}

void ExpertBeside::addTo(FrameState& seen, const training::DifficultyRules& rules, double tick_s) {
    shown_ = shown_ && rules.expert;
    if (!shown_) return;
    if (future_.valid() && future_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) try {
            made_.emplace(future_.get());
        } catch (const std::exception& e) {
            say_(fmt::format("the expert cannot be shown: {}", e.what()));
            shown_ = false;
        }
    if (!made_) return;
    if (step_ != seen.progress.step) {
        step_ = seen.progress.step, since_tick_ = seen.tick.tick;
        missing_ = made_->describeMissing(*step_);
        if (!missing_.empty()) say_(missing_);
    }
    const double since_s = tick_s * double(seen.tick.tick - since_tick_);
    seen.ghost_tool = made_->at(*step_, since_s, seen.tick.breath);
    if (since_s < kNoteShown_s) seen.expert_note = missing_;
    if (seen.ghost_tool) seen.ghost_tool->length_m = seen.needle.length_m;
}

}  // namespace stylet::trainer
