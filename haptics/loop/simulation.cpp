#include "haptics/loop/simulation.h"

#include <cmath>
#include <numbers>

#include "base/hash.h"
#include "base/transcendental.h"

namespace stylet::haptics {

using patient::Surrogate;

namespace {

Quat unit(const Quat& q) noexcept {
    const double norm = std::sqrt(glm::dot(q, q));
    return {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
}

// With one of these faults the last accepted pose is kept.
constexpr std::uint32_t kNoPose = kFaultBadPose | kFaultOutOfReach;

void hashSettings(StateHash& hash, const SimulationSettings& s) noexcept {
    hash.add(s.dt_s);
    hash.add(s.patient_from_device);
    hashToolSettings(hash, s.tools);
    hash.add(s.output.rate_limit_n_per_s);
    hash.add(s.output.model_force_n);
    hash.add(s.output.model_tangent_n_per_m);
    hash.add(s.output.controller_share);
    hash.add(s.profile.force_peak_n);
    hash.add(s.profile.stiffness_n_per_m);
    hash.add(s.profile.mass_kg);
    hash.add(s.profile.delay_s);
    hash.add(s.profile.workspace_centre_m);
    hash.add(s.profile.workspace_radius_m);
}

constexpr double kPerThousand = 1000.0;

std::uint32_t packed(double scale) noexcept {
    const bool number = scale >= kLeastBreathing;  // NaN becomes the minimum
    return std::uint32_t(
        std::floor((number ? std::fmin(scale, kMostBreathing) : kLeastBreathing) * kPerThousand + 0.5));
}

}  // namespace

Command breathingCommand(const BreathingScale& scale) noexcept {
    return {CommandKind::breathing, packed(scale.depth) << 16 | packed(scale.rate)};
}

BreathingScale breathingScale(const Command& command) noexcept {
    const auto unpacked = [](std::uint32_t v) {
        return std::fmin(std::fmax(double(v) / kPerThousand, kLeastBreathing), kMostBreathing);
    };
    return {unpacked(command.value >> 16), unpacked(command.value & 0xffffu)};
}

Simulation::Simulation(const patient::Patient& patient, const SimulationSettings& settings,
                       const TouchMap* touch)
    : patient_(&patient),
      settings_(settings),
      breath_(settings.breath.value_or(patient::BreathPlan{.rhythm = patient.package().signal})),
      rhythm_(breath_.rhythm),
      gain_(outputGain(settings.profile, settings.output)) {
    if (touch) touch_.emplace(*touch, settings.tools);
    state_.tools.in_hand = settings.tools.first;
    state_.hash.add(patient::digest(patient.package()));
    state_.hash.add(settings.scenario_digest);
    state_.hash.add(settings.seed);
    hashSettings(state_.hash, settings);
    patient::hashPlan(state_.hash, breath_);
}

void Simulation::step(const TickInput& input, TickOutput& out, NeedleEvents& events) noexcept {
    OutputTick tick;
    const bool taken = takeCommands(input, tick.unmet);
    stepBreath();
    patient::stepInterruption(state_.interruption, breath_, settings_.dt_s);
    const Vec3 started_m = movePatient();
    bool leapt = false;
    tick.unmet |= takePose(input.device, leapt);
    const bool refused = (tick.unmet & kNoPose) != 0;
    tick.grip_m = refused ? state_.output.grip_m : input.device.grip_m();
    tick.share = refused ? state_.output.share : input.device.share();

    const Surrogate breath = breathNow();
    ToolForce force;
    events.count = events.dropped = 0;
    if (state_.posed)
        force = stepTools(state_.tools, settings_.tools, touch(), {*patient_, breath},
                          state_.patient_from_stylus, events);
    force.event = force.event || taken || leapt;
    const Pose device_from_patient = settings_.patient_from_device.inverse();
    tick.tool = force;
    tick.tool.force_n = device_from_patient.direction(force.force_n);
    tick.tool.tissue_moved_m = device_from_patient.direction(force.tissue_moved_m + started_m);
    stepOutput(state_.output, settings_.output, settings_.profile, gain_, tick, settings_.dt_s);

    ++state_.tick;
    hashTick(input);
    describe(force, breath, out);
}

// Returns true if the active tool changed or a probe was parked or picked up.
bool Simulation::takeCommands(const TickInput& input, std::uint32_t& unmet) noexcept {
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
                rearm(state_.output.safety);
                break;
            case CommandKind::focus:
                state_.output.safety.focused = input.commands[i].value != 0;
                break;
            case CommandKind::tool:
                taken = takeTool(state_.tools, Tool(input.commands[i].value)) || taken;
                break;
            case CommandKind::park:
                taken = parkProbe(state_.tools, touch(), {*patient_, breathNow()},
                                  input.commands[i].value != 0) ||
                        taken;
                break;
            case CommandKind::cough:
                patient::interrupt(state_.interruption, state_.breathing, breath_,
                                   patient::InterruptionKind::cough);
                break;
            case CommandKind::sigh:
                patient::interrupt(state_.interruption, state_.breathing, breath_,
                                   patient::InterruptionKind::sigh);
                break;
            case CommandKind::move:
                if (state_.move_ticks == 0) state_.move_ticks = 1;
                break;
            case CommandKind::fault:
                unmet |= kFaultInjected;
                break;
            case CommandKind::breathing:
                state_.breathing_scale = breathingScale(input.commands[i]);
                break;
            case CommandKind::bleed:
            case CommandKind::lights:
            case CommandKind::marker:
            case CommandKind::inject:
            case CommandKind::pedal:
            case CommandKind::xray:
            case CommandKind::ultrasound:
                break;
        }
    }
    return taken;
}

// A breath-hold does not start during a cough or sigh. A breath or sigh that has started keeps its depth and
// length, so that nothing jumps.
void Simulation::stepBreath() noexcept {
    if (breath_.recording_v.empty() && state_.interruption.kind == patient::InterruptionKind::none)
        breath_.rhythm = {rhythm_.period_s / state_.breathing_scale.rate,
                          rhythm_.amplitude * state_.breathing_scale.depth};
    const bool wanted = state_.breathing.hold_wanted, interrupted = state_.interruption.ticks > 0;
    if (interrupted && !state_.breathing.held) state_.breathing.hold_wanted = false;
    patient::stepBreathing(state_.breathing, breath_, settings_.dt_s);
    if (interrupted) state_.breathing.hold_wanted = wanted;
}

Surrogate Simulation::breathNow() const noexcept {
    Surrogate now = patient::surrogateAt(state_.breathing, breath_, settings_.dt_s);
    const Surrogate over = patient::interruptionAt(state_.interruption, breath_, settings_.dt_s);
    now.v += over.v, now.rate_per_s += over.rate_per_s;
    return now;
}

// Returns the patient's displacement in this tick.
Vec3 Simulation::movePatient() noexcept {
    if (state_.move_ticks == 0) return Vec3(0.0);
    const double t_s = double(state_.move_ticks) * settings_.dt_s;
    const double s = t_s < kMove_s ? detSin(std::numbers::pi * t_s / kMove_s) : 0.0;
    const Vec3 before_m = state_.patient_moved_m;
    state_.patient_moved_m = (s * s * s * s) * kMoved_m;
    state_.move_ticks = t_s < kMove_s ? state_.move_ticks + 1 : 0;
    return state_.patient_moved_m - before_m;
}

// Returns the fault bits that forbid force.
std::uint32_t Simulation::takePose(const DeviceState& device, bool& leapt) noexcept {
    const std::uint32_t unmet = checkDevice(state_.output.safety, settings_.profile, device, settings_.dt_s);
    if ((unmet & kNoPose) != 0) return unmet;
    // Faster than any intended motion: no path through the patient, and no stab.
    if (state_.posed && state_.output.safety.speed_m_s > kOverSpeed_m_s) {
        leapt = leap(state_.tools);
        if (!leapt) return unmet;
    }
    const Pose stylus{unit(device.device_from_stylus.rotation), device.device_from_stylus.position_m};
    state_.patient_from_stylus = settings_.patient_from_device * stylus;
    state_.patient_from_stylus.position_m -= state_.patient_moved_m;
    state_.posed = true;
    return unmet;
}

void Simulation::hashTick(const TickInput& input) noexcept {
    StateHash& hash = state_.hash;
    hash.add(input.device.device_from_stylus);
    hash.add(std::uint64_t(input.device.buttons) | std::uint64_t(input.device.fresh) << 32);
    hash.add(std::uint64_t(input.device.flags) | std::uint64_t(input.command_count) << 32);
    if ((input.device.flags & kDeviceClutch) != 0) {
        hash.add(input.device.grip_at_m);
        hash.add(input.device.force_share);
    }
    for (std::uint32_t i = 0; i < input.command_count && i < std::uint32_t(kMaxCommandsPerTick); ++i) {
        hash.add(std::uint64_t(input.commands[i].kind) | std::uint64_t(input.commands[i].value) << 32);
    }
    hash.add(state_.tick);
    patient::hashBreathing(hash, state_.breathing);
    hashTools(hash, state_.tools);
    hashOutput(hash, state_.output);
    hash.add(state_.patient_from_stylus);
    hash.add(std::uint64_t(state_.posed));
    // Optional state is hashed only when active.
    if (state_.move_ticks > 0) hash.add(state_.move_ticks);
    if (!(state_.breathing_scale == BreathingScale{})) {
        hash.add(state_.breathing_scale.depth);
        hash.add(state_.breathing_scale.rate);
    }
    if (state_.interruption.ticks > 0)
        hash.add(std::uint64_t(state_.interruption.kind) << 32 | state_.interruption.ticks);
}

void Simulation::describe(const ToolForce& force, const Surrogate& breath, TickOutput& out) const noexcept {
    const ToolState& tools = state_.tools;
    const NeedleState& needle = tools.needle;
    out.tick = state_.tick;
    out.tool = tools.in_hand;
    out.tool_waits = tools.waits;
    out.tool_begun = tools.begun;
    out.patient_from_tool = tools.patient_from_tool;
    out.tool_force = force;
    out.patient_from_needle = tools.patient_from_needle;
    out.needle_in_guide = tools.guide.snapped;
    out.probe_parked = tools.probe.parked;
    out.patient_from_probe = tools.probe.patient_from_probe;
    out.probe_touching_share = tools.held_probe.touching_share;
    out.probe_pressure_pa = tools.held_probe.pressure_pa;
    out.tip_reference_m = needle.channel_reference_m;
    const Incisions& incisions = state_.tools.incisions;
    out.incision_count = incisions.count;
    out.newest_incision = incisions.count > 0 ? incisions.list[std::size_t(incisions.count - 1)] : Incision{};
    out.cut_incision = tools.in_hand == Tool::scalpel ? tools.scalpel.incision : -1;
    out.cut = out.cut_incision >= 0 ? incisions.list[std::size_t(out.cut_incision)] : Incision{};
    out.patient_moved_m = state_.patient_moved_m;
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
    out.controller_device_n = state_.output.controller_n;
    out.stage = state_.output.safety.stage;
    out.level = state_.output.safety.level;
    out.faults = state_.output.safety.faults;
    out.awaited = state_.output.safety.awaited;
    out.state_hash = state_.hash.value();
}

}  // namespace stylet::haptics
