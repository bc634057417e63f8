#include "haptics/simulation.h"

#include <cmath>

namespace stylet::haptics {

using patient::StateHash;
using patient::Surrogate;

namespace {

// No hand is further from the patient than this; a pose beyond it is a device gone wrong.
constexpr double kFarthest_m = 10.0;
// How far a rotation's length may be from 1: single-precision drivers stay far inside.
constexpr double kUnitTolerance = 1e-3;

bool isPose(const Pose& pose) noexcept {
    const Vec3& p = pose.position_m;
    const double norm2 = glm::dot(pose.rotation, pose.rotation);
    // Written so that NaN fails.
    return std::fabs(p.x) <= kFarthest_m && std::fabs(p.y) <= kFarthest_m && std::fabs(p.z) <= kFarthest_m &&
           std::fabs(norm2 - 1.0) <= kUnitTolerance;
}

Quat unit(const Quat& q) noexcept {
    const double norm = std::sqrt(glm::dot(q, q));
    return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

void hashSettings(StateHash& hash, const SimulationSettings& s) noexcept {
    hash.add(s.dt_s);
    hash.add(s.patient_from_device);
    hashToolSettings(hash, s.tools);
    hash.add(s.output.rate_limit_n_per_s);
    hash.add(s.output.model_force_n);
    hash.add(s.output.model_tangent_n_per_m);
    hash.add(s.profile.force_peak_n);
    hash.add(s.profile.stiffness_n_per_m);
}

}  // namespace

Simulation::Simulation(const patient::Patient& patient, const SimulationSettings& settings)
    : patient_(&patient),
      settings_(settings),
      breath_(settings.breath.value_or(patient::BreathPlan{.rhythm = patient.package().signal})),
      gain_(outputGain(settings.profile, settings.output)) {
    state_.tools.in_hand = settings.tools.first;
    state_.hash.add(patient::digest(patient.package()));
    state_.hash.add(settings.scenario_digest);
    state_.hash.add(settings.seed);
    hashSettings(state_.hash, settings);
    patient::hashPlan(state_.hash, breath_);
}

void Simulation::step(const TickInput& input, TickOutput& out, NeedleEvents& events) noexcept {
    const bool taken = takeCommands(input);
    patient::stepBreathing(state_.breathing, breath_, settings_.dt_s);
    takePose(input.device);

    const Surrogate breath = patient::surrogateAt(state_.breathing, breath_, settings_.dt_s);
    ToolForce force;
    events.count = events.dropped = 0;
    if (state_.posed)
        force =
            stepTools(state_.tools, settings_.tools, *patient_, state_.patient_from_stylus, breath, events);
    force.event = force.event || taken;
    const Vec3 force_device_n = settings_.patient_from_device.inverse().direction(force.force_n);
    stepOutput(state_.output, settings_.output, settings_.profile, gain_, force_device_n, settings_.dt_s);

    ++state_.tick;
    hashTick(input);
    describe(force, breath, out);
}

// True when another tool is in hand now.
bool Simulation::takeCommands(const TickInput& input) noexcept {
    bool taken = false;
    for (std::uint32_t i = 0; i < input.command_count && i < std::uint32_t(kMaxCommandsPerTick); ++i) {
        switch (input.commands[i].kind) {
            case CommandKind::holdBreath:
                patient::commandHold(state_.breathing, true);
                break;
            case CommandKind::breathe:
                patient::commandHold(state_.breathing, false);
                break;
            case CommandKind::rearm:
                state_.output.faults = 0;
                break;
            case CommandKind::tool:
                taken = takeTool(state_.tools, Tool(input.commands[i].value)) || taken;
                break;
            case CommandKind::park:
                parkProbe(state_.tools, *patient_,
                          patient::surrogateAt(state_.breathing, breath_, settings_.dt_s),
                          input.commands[i].value != 0);
                break;
            case CommandKind::marker:
                break;
        }
    }
    return taken;
}

void Simulation::takePose(const DeviceState& device) noexcept {
    state_.stale_ticks = device.fresh != 0 ? 0 : state_.stale_ticks + 1;
    if (double(state_.stale_ticks) * settings_.dt_s >= kStaleInput_s)
        state_.output.faults |= kFaultStaleInput;
    if (!isPose(device.device_from_stylus)) {
        state_.output.faults |= kFaultNotFinite;
        return;
    }
    const Pose stylus{unit(device.device_from_stylus.rotation), device.device_from_stylus.position_m};
    state_.patient_from_stylus = settings_.patient_from_device * stylus;
    state_.posed = true;
}

void Simulation::hashTick(const TickInput& input) noexcept {
    StateHash& hash = state_.hash;
    hash.add(input.device.device_from_stylus);
    hash.add(std::uint64_t(input.device.buttons) | std::uint64_t(input.device.fresh) << 32);
    hash.add(std::uint64_t(input.device.flags) | std::uint64_t(input.command_count) << 32);
    for (std::uint32_t i = 0; i < input.command_count && i < std::uint32_t(kMaxCommandsPerTick); ++i) {
        hash.add(std::uint64_t(input.commands[i].kind) | std::uint64_t(input.commands[i].value) << 32);
    }
    hash.add(state_.tick);
    patient::hashBreathing(hash, state_.breathing);
    hashTools(hash, state_.tools);
    hash.add(state_.output.model_n);
    hash.add(state_.output.sent_n);
    hash.add(std::uint64_t(state_.output.faults) | std::uint64_t(state_.output.limited) << 32);
    hash.add(state_.patient_from_stylus);
    hash.add(std::uint64_t(state_.posed) | std::uint64_t(state_.stale_ticks) << 1);
}

void Simulation::describe(const ToolForce& force, const Surrogate& breath, TickOutput& out) const noexcept {
    const ToolState& tools = state_.tools;
    const NeedleState& needle = tools.needle;
    out.tick = state_.tick;
    out.tool = tools.in_hand;
    out.patient_from_tool = tools.patient_from_tool;
    out.tool_force = force;
    out.patient_from_needle = tools.patient_from_needle;
    out.needle_in_guide = tools.guide.snapped;
    out.probe_parked = tools.probe.parked;
    out.patient_from_probe = tools.probe.patient_from_probe;
    out.tip_reference_m = needle.channel_reference_m;
    out.breath = breath;
    out.breath_held = state_.breathing.held;
    out.phase = needle.phase;
    out.tissue = needle.tissue;
    out.label = needle.label;
    out.depth_m = needle.depth_m;
    out.force_n = needle.force_n;
    out.extension_m = proxyDistance(needle);
    out.lateral_cut_m = needle.lateral_cut_m;
    out.sent_device_n = state_.output.sent_n;
    out.faults = state_.output.faults;
    out.state_hash = state_.hash.value();
}

}  // namespace stylet::haptics
