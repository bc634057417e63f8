// One tick of everything that is hashed: a fold over (package, scenario, per-tick device state and commands).
// No clock, no thread, no I/O: the loop (loop.h), a replay and a test call the same step().
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "haptics/device.h"
#include "haptics/output.h"
#include "haptics/toolbox.h"
#include "patient/interruption.h"

namespace stylet::haptics {

enum class CommandKind : std::uint32_t {
    holdBreath,
    breathe,
    rearm,  // the explicit act after a fault (safety.h)
    marker,
    tool,   // value: the Tool to take in hand
    park,   // value: 1 leaves the probe where it is held, 0 takes it off the skin
    focus,  // value: 0 takes the force away: the session is not seen or the headset is off
    // Not felt: hashed and logged with their tick like the others (app/training/machines.h).
    inject,      // value: contrast medium at the needle's tip, microlitres a second; 0 ends it
    pedal,       // value: 1 X-rays, 0 none
    xray,        // value: a knob of the C-arm, and where to
    ultrasound,  // the same of the ultrasound machine
    // The instructor's.
    cough,
    sigh,       // both at once, laid over the breath; a hold ends in them
    move,       // the patient starts, and comes back (kMove_s)
    fault,      // as if the device had failed: kFaultInjected
    bleed,      // not felt: the newest hole in the skin bleeds
    lights,     // not felt; value: 0 puts the lamps out, 1 on
    breathing,  // value: breathingCommand(); from his next breath on
};
inline constexpr CommandKind kLastCommandKind = CommandKind::breathing;

// How he starts: a way there and back, no faster than 17 mm/s, smooth to the third derivative.
inline constexpr double kMove_s = 1.6;
inline constexpr Vec3 kMoved_m{-0.005, 0.001, 0.004};  // patient frame; away from a needle in his right flank

// A command takes effect in the tick that pops it; that tick is logged with it.
struct Command {
    CommandKind kind = CommandKind::marker;
    std::uint32_t value = 0;  // marker: the scenario's moment; others: see there
};
// So many times as deep and as quick as in the plan; a recorded breath stays as it was recorded.
struct BreathingScale {
    double depth = 1.0, rate = 1.0;
    friend bool operator==(const BreathingScale&, const BreathingScale&) = default;
};
inline constexpr double kLeastBreathing = 0.5, kMostBreathing = 2.0;
// Rounded to a thousandth, and kept between these two; as packed into the command's value, and back.
Command breathingCommand(const BreathingScale&) noexcept;
BreathingScale breathingScale(const Command&) noexcept;

// A run in which one is given needs a TouchMap.
constexpr bool takesToolOnSkin(const Command& c) noexcept {
    return c.kind == CommandKind::tool && c.value < std::uint32_t(kToolCount) && pressesOnSkin(Tool(c.value));
}
inline constexpr int kMaxCommandsPerTick = 8;

struct TickInput {
    DeviceState device;
    std::uint32_t command_count = 0;
    std::array<Command, kMaxCommandsPerTick> commands{};
};

struct SimulationSettings {
    double dt_s = 0.001;
    Pose patient_from_device;
    std::optional<patient::BreathPlan> breath;  // absent: the patient's own rhythm, and he complies
    ToolSettings tools;
    OutputSettings output;
    DeviceProfile profile;
    std::uint64_t scenario_digest = 0;  // folded into the hash first, with the package's digest
    std::uint64_t seed = 0;
};

struct SimulationState {
    std::uint64_t tick = 0;
    patient::BreathingState breathing;
    patient::Interruption interruption;
    BreathingScale breathing_scale;  // as commanded last
    ToolState tools;
    OutputState output;
    // A pose that cannot be is refused, and a leap with the needle in the body: the last good one stays.
    Pose patient_from_stylus;
    bool posed = false;            // there has been a good pose
    std::uint64_t move_ticks = 0;  // since he started; 0: he lies still
    Vec3 patient_moved_m{0.0};     // from where he lay
    patient::StateHash hash;       // running: covers every tick so far
};

// What the picture and the session may know of a tick. Trivially copyable: it travels in snapshots and rings.
struct TickOutput {
    std::uint64_t tick = 0;
    Tool tool = Tool::needle;      // in hand
    bool tool_waits = true;        // and is not felt before it has been outside the body
    std::uint32_t tool_begun = 0;  // how often one was taken up, or leapt to where it is
    Pose patient_from_tool;        // as held; tip at the origin, +z toward the hand
    ToolForce tool_force;          // of the model, patient frame
    Pose patient_from_needle;  // on the rail while it is snapped in; the last one while another tool is held
    bool needle_in_guide = false;
    bool probe_parked = false;
    Pose patient_from_probe;            // of the parked one
    double probe_touching_share = 0.0;  // of the face of the probe in hand: the rest shows nothing
    double probe_pressure_pa = 0.0;
    Vec3 tip_reference_m{0.0};  // where the needle's tissue is looked up
    int incision_count = 0;     // of the scalpel
    Incision newest_incision;
    int cut_incision = -1;  // of these the one that is cut now, and as it is now
    Incision cut;
    Vec3 patient_moved_m{0.0};  // the patient frame itself, from where it was at first
    patient::Surrogate breath;
    bool breath_held = false;
    Phase phase = Phase::outside;
    Tissue tissue = Tissue::air;
    std::uint8_t label = 0;
    double depth_m = 0.0, force_n = 0.0;  // axial, model
    double extension_m = 0.0;             // proxy behind tip
    double lateral_cut_m = 0.0;
    Vec3 sent_device_n{0.0};        // after the output stage, device frame
    Vec3 controller_device_n{0.0};  // the passivity controller's part of it
    ForceStage stage = ForceStage::waiting;
    double level = 0.0;         // share of the force that is sent
    std::uint32_t faults = 0;   // Fault bits
    std::uint32_t awaited = 0;  // Fault bits that keep the force from beginning
    std::uint64_t state_hash = 0;
};

class Simulation {
  public:
    // `touch`: what finger, probe and scalpel press on; without it they feel nothing. While none of them is
    // taken the hash is the same with and without.
    Simulation(const patient::Patient&, const SimulationSettings&, const TouchMap* touch = nullptr);

    // Haptics thread. noexcept, no allocation, no lock, no I/O.
    void step(const TickInput&, TickOutput&, NeedleEvents&) noexcept STYLET_NONBLOCKING;

    const SimulationState& state() const noexcept { return state_; }
    const SimulationSettings& settings() const noexcept { return settings_; }
    double gain() const noexcept { return gain_; }

  private:
    bool takeCommands(const TickInput&, std::uint32_t& unmet) noexcept;
    void stepBreath() noexcept;
    Vec3 movePatient() noexcept;
    patient::Surrogate breathNow() const noexcept;
    std::uint32_t takePose(const DeviceState&, bool& leapt) noexcept;
    void hashTick(const TickInput&) noexcept;
    void describe(const ToolForce&, const patient::Surrogate& breath, TickOutput&) const noexcept;

    const TouchTools* touch() const noexcept { return touch_ ? &*touch_ : nullptr; }

    const patient::Patient* patient_;
    std::optional<TouchTools> touch_;
    SimulationSettings settings_;
    patient::BreathPlan breath_;  // its rhythm as scaled
    patient::BreathingSignal rhythm_;
    SimulationState state_;
    double gain_ = 1.0;
};

}  // namespace stylet::haptics
