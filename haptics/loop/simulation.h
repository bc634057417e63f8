// One tick of all hashed state. The result depends only on the package, the scenario, and the device state
// and commands of each tick. No clock, no thread, no I/O. The loop (loop.h), a replay and a test all call the
// same step().
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/hash.h"
#include "haptics/loop/toolbox.h"
#include "haptics/output/output.h"
#include "haptics/output/stored_energy.h"
#include "haptics/tools/device.h"
#include "patient/motion/interruption.h"

namespace stylet::haptics {

enum class CommandKind : std::uint32_t {
    holdBreath,
    breathe,
    rearm,  // re-arm after a fault (safety.h)
    marker,
    tool,   // value: the Tool to select
    park,   // value: 1 parks the probe where it is, 0 takes it off the skin
    focus,  // value: 0 removes the force: the session is not visible or the headset is off
    // These cause no force. They are hashed and logged with their tick like the others
    // (app/training/equipment.h).
    inject,      // value: contrast medium at the needle's tip, microlitres per second; 0 stops it
    pedal,       // value: 1 X-rays on, 0 off
    xray,        // value: a C-arm control and its new setting
    ultrasound,  // the same for the ultrasound machine
    // Sent by the instructor.
    cough,
    sigh,       // cough and sigh start at once and are added to the breathing; they end a breath-hold
    move,       // the patient startles: moves and returns within kStartleDuration_s
    fault,      // simulates a device failure: kFaultInjected
    bleed,      // not felt: the newest needle hole in the skin bleeds
    lights,     // not felt; value: 0 switches the lamps off, 1 on
    breathing,  // value: breathingCommand(); takes effect with the next breath
    // Equipment again: draws with a syringe at the needle.
    aspirate,
    anaesthetic,  // value: local anaesthetic at the needle's tip, microlitres per second; 0 stops it
    answer,       // to a question about the patient's case (app/training/case_review.h): 1 yes, 0 no
    grip,         // value: 0 lets go of the tool on the track of an access, 1 grips it again (gripTool)
};
inline constexpr CommandKind kLastCommandKind = CommandKind::grip;

// Startle motion: there and back at 17 mm/s or less, smooth to the third derivative.
inline constexpr double kStartleDuration_s = 1.6;
inline constexpr Vec3 kStartleDisplacement_m{-0.005, 0.001,
                                             0.004};  // patient frame; away from a needle in the right flank

// A command takes effect in the tick that pops it, and is logged with that tick.
struct Command {
    CommandKind kind = CommandKind::marker;
    std::uint32_t value = 0;  // marker: any number; others: see CommandKind
};
// Factors on depth and rate of the planned breathing. A recorded breathing signal is not scaled.
struct BreathingScale {
    double depth = 1.0, rate = 1.0;
    friend bool operator==(const BreathingScale&, const BreathingScale&) = default;
};
inline constexpr double kMinBreathingScale = 0.5, kMaxBreathingScale = 2.0;
// Packs the factors into a command's value, and unpacks them. Both are clamped to [kMinBreathingScale,
// kMaxBreathingScale] and rounded to 0.001. NaN becomes the minimum.
Command breathingCommand(const BreathingScale&) noexcept;
BreathingScale breathingScale(const Command&) noexcept;

// True if the command selects a tool that presses on the skin. Such a run needs a TouchMap.
constexpr bool selectsSkinTool(const Command& c) noexcept {
    return c.kind == CommandKind::tool && c.value < std::uint32_t(kToolCount) && pressesOnSkin(Tool(c.value));
}
// True if the command selects a tool that follows the guide wire. Such a run needs a DuctSpace.
constexpr bool selectsAccessTool(const Command& c) noexcept {
    return c.kind == CommandKind::tool && c.value < std::uint32_t(kToolCount) && isAccessTool(Tool(c.value));
}
inline constexpr int kMaxCommandsPerTick = 8;

// A device that leapt away from the needle in the body and then stays outside the body this long has drawn
// the needle out. A glitch of a tracker is shorter.
inline constexpr double kDrawnOut_s = 0.5;
// After a longer absence of the device, the way that it took is unknown, and a tool that cuts is not swept
// along it.
inline constexpr double kAbsent_s = 0.25;

struct TickInput {
    DeviceState device;
    std::uint32_t command_count = 0;
    std::array<Command, kMaxCommandsPerTick> commands{};

    // Commands beyond kMaxCommandsPerTick are ignored.
    std::span<const Command> validCommands() const noexcept {
        return std::span(commands).first(std::min(std::size_t(command_count), commands.size()));
    }
    // Call it at most kMaxCommandsPerTick times per tick.
    void add(const Command& command) noexcept {
        assert(command_count < commands.size());
        commands[command_count++] = command;
    }
};

struct SimulationSettings {
    double dt_s = 0.001;
    Pose patient_from_device;
    std::optional<patient::BreathPlan> breath;  // absent: the package's rhythm; breath-holds are followed
    ToolSettings tools;
    OutputSettings output;
    DeviceProfile profile;
    std::uint64_t scenario_digest = 0;  // added to the hash first, with the package's digest
    std::uint64_t seed = 0;
};

struct SimulationState {
    std::uint64_t tick = 0;
    patient::BreathingState breathing;
    patient::Interruption interruption;
    BreathingScale breathing_scale;  // as last commanded
    ToolState tools;
    StoredEnergy stored;
    OutputState output;
    // The last accepted pose. Implausible poses are refused, and so is a leap while the needle is in the
    // body.
    Pose patient_from_stylus;
    bool has_pose = false;  // there has been an accepted pose
    // The device leapt away from the needle in the body. The needle keeps its pose until the device is back
    // (kRejoin_m) or has been outside the body for kDrawnOut_s.
    bool left_needle = false;
    double outside_s = 0.0;  // for how long it has been outside the body since
    // For how long the device has been lost, silent, late or at an impossible pose since its last motion.
    double absent_s = 0.0;
    std::uint64_t move_ticks = 0;  // since the startle began; 0: the patient lies still
    Vec3 patient_moved_m{0.0};     // displacement from the initial position
    StateHash hash;                // running hash of every tick so far
};

// Result of one tick for rendering and the session. Trivially copyable: it travels in snapshots and rings.
struct TickOutput {
    std::uint64_t tick = 0;
    Tool tool = Tool::needle;       // the active tool
    bool tool_awaits_exit = true;   // it gives no force until it has been outside the body
    std::uint32_t tool_resets = 0;  // number of tool changes and leaps so far
    Pose patient_from_tool;         // stylus pose; tip at the origin, +z toward the hand
    ToolForce tool_force;           // of the model, patient frame
    Pose patient_from_needle;  // On the rail while snapped in. The last pose while another tool is active.
    bool needle_in_guide = false;
    bool probe_parked = false;
    Pose patient_from_probe;  // of the parked probe
    // Share of the hand-held probe's face in contact; the rest shows no image.
    double probe_touching_share = 0.0;
    double probe_pressure_pa = 0.0;
    Vec3 tip_reference_m{0.0};  // where the needle's tissue is looked up
    int incision_count = 0;     // number of incisions made by the scalpel
    Incision newest_incision;
    int cut_incision = -1;  // Index of the incision being cut, or -1.
    Incision cut;
    Vec3 patient_moved_m{0.0};  // displacement of the patient frame from its initial position
    patient::Surrogate breath;
    bool breath_held = false;
    // The cough or sigh on command that is under way.
    patient::InterruptionKind interruption = patient::InterruptionKind::none;
    Phase phase = Phase::outside;
    Tissue tissue = Tissue::air;
    std::uint8_t label = 0;
    double depth_m = 0.0, force_n = 0.0;  // axial, model
    double extension_m = 0.0;             // distance of the proxy behind the tip
    double lateral_cut_m = 0.0;
    Vec3 sent_device_n{0.0};        // after the output stage, device frame
    Vec3 controller_device_n{0.0};  // the passivity controller's part of it
    ForceStage stage = ForceStage::waiting;
    double level = 0.0;         // fraction of the force that is sent
    std::uint32_t faults = 0;   // Fault bits
    std::uint32_t awaited = 0;  // Fault bits that prevent the force from starting
    AccessOutput access;        // wire, dilator and drain
    std::uint64_t state_hash = 0;
};

class Simulation {
  public:
    // `touch` is the skin map that finger, probe and scalpel press on. Without it they give no force. As long
    // as none of them is selected, the hash is the same with and without it. The same holds for `ducts` and
    // the wire. Both must outlive the simulation.
    Simulation(const patient::Patient&, const SimulationSettings&, const TouchMap* touch = nullptr,
               const patient::DuctSpace* ducts = nullptr);

    // Haptics thread. noexcept, no allocation, no lock, no I/O.
    void step(const TickInput&, TickOutput&, NeedleEvents&) noexcept STYLET_NONBLOCKING;

    const SimulationState& state() const noexcept { return state_; }
    const SimulationSettings& settings() const noexcept { return settings_; }
    double gain() const noexcept { return gain_; }

  private:
    bool applyCommands(const TickInput&, std::uint32_t& fault_bits) noexcept;
    void stepBreath() noexcept;
    Vec3 stepStartle() noexcept;
    patient::Surrogate currentBreath() const noexcept;
    struct PoseUpdate;
    PoseUpdate updatePose(const DeviceState&, const patient::Surrogate& breath) noexcept;
    void followDevice(const DeviceState&, const patient::Surrogate& breath, PoseUpdate&) noexcept;
    void hashTick(const TickInput&) noexcept;
    void fillOutput(const ToolForce&, const patient::Surrogate& breath, TickOutput&) const noexcept;

    const TouchTools* touch() const noexcept { return touch_ ? &*touch_ : nullptr; }
    BreathingPatient now(const patient::Surrogate& breath) const noexcept {
        return {*patient_, breath, ducts_};
    }

    const patient::Patient* patient_;
    std::optional<TouchTools> touch_;
    const patient::DuctSpace* ducts_;
    SimulationSettings settings_;
    patient::BreathPlan breath_;  // with its rhythm scaled
    patient::BreathingSignal rhythm_;
    SimulationState state_;
    double gain_ = 1.0;
};

}  // namespace stylet::haptics
