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
constexpr std::uint32_t kPoseFaults = kFaultBadPose | kFaultOutOfReach;
// With one of these faults it is unknown where the device is.
constexpr std::uint32_t kAbsenceFaults = kPoseFaults | kFaultDeviceLost | kFaultStaleInput | kFaultHostLate;

void hashSettings(StateHash& hash, const SimulationSettings& s) noexcept {
    hash.add(s.dt_s, s.patient_from_device);
    hashToolSettings(hash, s.tools);
    const OutputSettings& o = s.output;
    hash.add(o.rate_limit_n_per_s, o.model_force_n, o.model_tangent_n_per_m, o.controller_share);
    const DeviceProfile& p = s.profile;
    hash.add(p.force_peak_n, p.stiffness_n_per_m, p.mass_kg, p.delay_s);
    hash.add(p.workspace_centre_m, p.workspace_radius_m);
}

constexpr double kPerThousand = 1000.0;

std::uint32_t packScale(double scale) noexcept {
    const bool number = scale >= kMinBreathingScale;  // NaN becomes the minimum
    return std::uint32_t(std::floor(
        (number ? std::fmin(scale, kMaxBreathingScale) : kMinBreathingScale) * kPerThousand + 0.5));
}

}  // namespace

Command breathingCommand(const BreathingScale& scale) noexcept {
    return {CommandKind::breathing, packScale(scale.depth) << 16 | packScale(scale.rate)};
}

BreathingScale breathingScale(const Command& command) noexcept {
    const auto unpacked = [](std::uint32_t v) {
        return std::fmin(std::fmax(double(v) / kPerThousand, kMinBreathingScale), kMaxBreathingScale);
    };
    return {unpacked(command.value >> 16), unpacked(command.value & 0xffffu)};
}

Simulation::Simulation(const patient::Patient& patient, const SimulationSettings& settings,
                       const TouchMap* touch, const patient::DuctSpace* ducts)
    : patient_(&patient),
      ducts_(ducts),
      settings_(settings),
      breath_(settings.breath.value_or(patient::BreathPlan{.rhythm = patient.package().signal})),
      rhythm_(breath_.rhythm),
      gain_(outputGain(settings.profile, settings.output)) {
    if (touch) touch_.emplace(*touch, settings.tools);
    state_.tools.active_tool = settings.tools.first;
    state_.tools.access_digest = digest(settings.tools.access);
    state_.hash.add(patient::digest(patient.package()), settings.scenario_digest, settings.seed);
    hashSettings(state_.hash, settings);
    patient::hashPlan(state_.hash, breath_);
}

struct Simulation::PoseUpdate {
    std::uint32_t fault_bits = 0;  // bits that forbid force
    bool reseated = false;
    std::optional<NeedleEvent> drawn_out;
};

void Simulation::step(const TickInput& input, TickOutput& out, NeedleEvents& events) noexcept {
    OutputTick tick;
    const bool tool_changed = applyCommands(input, tick.fault_bits);
    stepBreath();
    patient::stepInterruption(state_.interruption, breath_, settings_.dt_s);
    const Vec3 startle_m = stepStartle();
    const Surrogate breath = currentBreath();
    const PoseUpdate pose = updatePose(input.device, breath);
    tick.fault_bits |= pose.fault_bits;
    const bool refused = (tick.fault_bits & kPoseFaults) != 0;
    tick.grip_m = refused ? state_.output.grip_m : input.device.grip_m();
    tick.share = refused ? state_.output.share : input.device.share();

    ToolForce force;
    const Vec3 last_tip_m = state_.tools.patient_from_tool.position_m;
    events.count = events.dropped = 0;
    if (state_.has_pose)
        force = stepTools(state_.tools, settings_.tools, touch(), now(breath), state_.patient_from_stylus,
                          events);
    if (pose.drawn_out) events.add(*pose.drawn_out);
    force.event = force.event || tool_changed || pose.reseated;
    const Pose device_from_patient = settings_.patient_from_device.inverse();
    const Vec3 moved_m = state_.tools.patient_from_tool.position_m - last_tip_m;
    const ToolForce bounded = boundByStoredEnergy(state_.stored, force, moved_m);
    tick.tool = settings_.output.controller_share > 0.0 ? bounded : force;
    tick.tool.force_n = device_from_patient.direction(tick.tool.force_n);
    tick.tool.tissue_moved_m = device_from_patient.direction(force.tissue_moved_m + startle_m);
    stepOutput(state_.output, settings_.output, settings_.profile, gain_, tick, settings_.dt_s);

    ++state_.tick;
    hashTick(input);
    fillOutput(force, breath, out);
}

// Returns true if the active tool or the grip on it changed, or a probe was parked or picked up.
bool Simulation::applyCommands(const TickInput& input, std::uint32_t& fault_bits) noexcept {
    bool tool_changed = false;
    for (const Command& command : input.validCommands()) {
        switch (command.kind) {
            case CommandKind::holdBreath:
            case CommandKind::breathe:
                patient::commandHold(state_.breathing, command.kind == CommandKind::holdBreath);
                break;
            case CommandKind::rearm:
                rearm(state_.output.safety);
                break;
            case CommandKind::focus:
                state_.output.safety.focused = command.value != 0;
                break;
            case CommandKind::tool:
                tool_changed |= selectTool(state_.tools, Tool(command.value));
                break;
            case CommandKind::park:
                tool_changed |=
                    parkProbe(state_.tools, touch(), {*patient_, currentBreath()}, command.value != 0);
                break;
            case CommandKind::grip:
                tool_changed |= gripTool(state_.tools, command.value != 0);
                break;
            case CommandKind::cough:
            case CommandKind::sigh:
                patient::interrupt(state_.interruption, state_.breathing, breath_,
                                   command.kind == CommandKind::cough ? patient::InterruptionKind::cough
                                                                      : patient::InterruptionKind::sigh);
                break;
            case CommandKind::move:
                if (state_.move_ticks == 0) state_.move_ticks = 1;
                break;
            case CommandKind::fault:
                fault_bits |= kFaultInjected;
                break;
            case CommandKind::breathing:
                state_.breathing_scale = breathingScale(command);
                break;
            case CommandKind::bleed:
            case CommandKind::lights:
            case CommandKind::marker:
            case CommandKind::inject:
            case CommandKind::pedal:
            case CommandKind::xray:
            case CommandKind::ultrasound:
            case CommandKind::aspirate:
            case CommandKind::anaesthetic:
            case CommandKind::answer:
                break;
        }
    }
    return tool_changed;
}

// A breath-hold does not start during a cough or sigh. A breath or sigh that has started keeps its depth and
// length, so that the motion does not jump.
void Simulation::stepBreath() noexcept {
    if (breath_.recording_v.empty() && state_.interruption.kind == patient::InterruptionKind::none)
        breath_.rhythm = {rhythm_.period_s / state_.breathing_scale.rate,
                          rhythm_.amplitude * state_.breathing_scale.depth};
    const bool wanted = state_.breathing.hold_wanted, interrupted = state_.interruption.ticks > 0;
    if (interrupted && !state_.breathing.held) state_.breathing.hold_wanted = false;
    patient::stepBreathing(state_.breathing, breath_, settings_.dt_s);
    if (interrupted) state_.breathing.hold_wanted = wanted;
}

Surrogate Simulation::currentBreath() const noexcept {
    Surrogate now = patient::surrogateAt(state_.breathing, breath_, settings_.dt_s);
    const Surrogate over = patient::interruptionAt(state_.interruption, breath_, settings_.dt_s);
    now.v += over.v, now.rate_per_s += over.rate_per_s;
    return now;
}

// Returns the patient's displacement in this tick.
Vec3 Simulation::stepStartle() noexcept {
    if (state_.move_ticks == 0) return Vec3(0.0);
    const double t_s = double(state_.move_ticks) * settings_.dt_s;
    const double s = t_s < kStartleDuration_s ? detSin(std::numbers::pi * t_s / kStartleDuration_s) : 0.0;
    const Vec3 before_m = state_.patient_moved_m;
    state_.patient_moved_m = (s * s * s * s) * kStartleDisplacement_m;
    state_.move_ticks = t_s < kStartleDuration_s ? state_.move_ticks + 1 : 0;
    return state_.patient_moved_m - before_m;
}

Simulation::PoseUpdate Simulation::updatePose(const DeviceState& device, const Surrogate& breath) noexcept {
    PoseUpdate update;
    update.fault_bits = checkDevice(state_.output.safety, settings_.profile, device, settings_.dt_s);
    if ((update.fault_bits & kAbsenceFaults) != 0) state_.absent_s += settings_.dt_s;
    if ((update.fault_bits & kPoseFaults) == 0)
        followDevice(device, breath, update);
    else
        state_.outside_s = 0.0;
    if (state_.left_needle) update.fault_bits |= kFaultAwayFromNeedle;
    return update;
}

// Moves the tool to the device's pose. A leap does not sweep it through the patient.
void Simulation::followDevice(const DeviceState& device, const Surrogate& breath,
                              PoseUpdate& update) noexcept {
    const Pose reported{unit(device.device_from_stylus.rotation), device.device_from_stylus.position_m};
    Pose stylus = settings_.patient_from_device * reported;
    stylus.position_m -= state_.patient_moved_m;
    const double max_speed_m_s = state_.left_needle ? kSlowEnough_m_s : kOverSpeed_m_s;
    // After an absence the device may be anywhere, and its mean speed is low. Until it has a new pose, it
    // repeats the old one.
    const double step_m = glm::distance(stylus.position_m, state_.patient_from_stylus.position_m);
    const bool is_back = (update.fault_bits & kAbsenceFaults) == 0 && step_m > 0.0;
    const bool moved_unseen =
        is_back && state_.absent_s > kAbsent_s && step_m > kRejoin_m && cutsTissue(state_.tools.active_tool);
    if (is_back) state_.absent_s = 0.0;
    const bool leapt = state_.has_pose && (state_.output.safety.speed_m_s > max_speed_m_s || moved_unseen);
    Following following =
        state_.has_pose ? findFollowing(state_.tools, stylus.position_m, leapt) : Following::follows;
    if (following == Following::stays) {
        state_.left_needle = true;
        const bool lost = (update.fault_bits & (kFaultStaleInput | kFaultDeviceLost | kFaultHandOff)) != 0;
        const bool outside = !leapt && !lost && isInOpenAir({*patient_, breath}, stylus.position_m);
        state_.outside_s = outside ? state_.outside_s + settings_.dt_s : 0.0;
        if (state_.outside_s < kDrawnOut_s) return;
        update.drawn_out = drawOutNeedle(state_.tools.needle);
        following = Following::reseats;
    }
    if (following == Following::reseats) resetContact(state_.tools);
    update.reseated = following == Following::reseats;
    state_.left_needle = false;
    state_.outside_s = 0.0;
    state_.patient_from_stylus = stylus;
    state_.has_pose = true;
}

void Simulation::hashTick(const TickInput& input) noexcept {
    StateHash& hash = state_.hash;
    hash.add(input.device.device_from_stylus,
             std::uint64_t(input.device.buttons) | std::uint64_t(input.device.fresh) << 32,
             std::uint64_t(input.device.flags) | std::uint64_t(input.command_count) << 32);
    if ((input.device.flags & kDeviceClutch) != 0) hash.add(input.device.grip_at_m, input.device.force_share);
    for (const Command& command : input.validCommands())
        hash.add(std::uint64_t(command.kind) | std::uint64_t(command.value) << 32);
    hash.add(state_.tick);
    patient::hashBreathing(hash, state_.breathing);
    hashTools(hash, state_.tools);
    hashStoredEnergy(hash, state_.stored);
    hashOutput(hash, state_.output);
    hash.add(state_.patient_from_stylus, std::uint64_t(state_.has_pose));
    // Optional state is hashed only when active.
    if (state_.move_ticks > 0) hash.add(state_.move_ticks);
    if (state_.left_needle) hash.add(state_.outside_s);
    if (!(state_.breathing_scale == BreathingScale{}))
        hash.add(state_.breathing_scale.depth, state_.breathing_scale.rate);
    if (state_.interruption.ticks > 0)
        hash.add(std::uint64_t(state_.interruption.kind) << 32 | state_.interruption.ticks);
}

void Simulation::fillOutput(const ToolForce& force, const Surrogate& breath, TickOutput& out) const noexcept {
    const ToolState& tools = state_.tools;
    const NeedleState& needle = tools.needle;
    out.tick = state_.tick;
    out.tool = tools.active_tool;
    out.tool_awaits_exit = tools.awaits_exit;
    out.tool_resets = tools.reset_count;
    out.patient_from_tool = tools.patient_from_tool;
    out.tool_force = force;
    out.patient_from_needle = tools.patient_from_needle;
    out.needle_in_guide = tools.guide.snapped;
    out.probe_parked = tools.probe.parked;
    out.patient_from_probe = tools.probe.patient_from_probe;
    out.probe_touching_share = tools.handheld_probe.touching_share;
    out.probe_pressure_pa = tools.handheld_probe.pressure_pa;
    out.tip_reference_m = needle.channel_reference_m;
    const Incisions& incisions = tools.incisions;
    out.incision_count = incisions.count;
    out.newest_incision = incisions.count > 0 ? incisions.list[std::size_t(incisions.count - 1)] : Incision{};
    out.cut_incision = tools.active_tool == Tool::scalpel ? tools.scalpel.incision : -1;
    out.cut = out.cut_incision >= 0 ? incisions.list[std::size_t(out.cut_incision)] : Incision{};
    out.patient_moved_m = state_.patient_moved_m;
    out.breath = breath;
    out.breath_held = state_.breathing.held;
    out.interruption = state_.interruption.kind;
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
    summarize(tools.access, ducts_, out.access);
    out.state_hash = state_.hash.value();
}

}  // namespace stylet::haptics
