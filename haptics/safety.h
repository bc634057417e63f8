// When a device may push at all: what has to hold, how the force comes and goes, and the name of every reason
// for which it does not.
#pragma once

#include <cstdint>
#include <span>

#include "haptics/device.h"
#include "patient/hash.h"

namespace stylet::haptics {

// Causes. A set bit stays until the run is re-armed (CommandKind::rearm). All but kFaultRingFull take the
// force away.
enum Fault : std::uint32_t {
    kFaultBadForce = 1u << 0,    // a model's force, energy or tissue motion is not finite
    kFaultStaleInput = 1u << 1,  // kStaleInput_s without a fresh good pose
    kFaultRingFull = 1u << 2,    // the loop's alone: the session's pace must not enter the hashed state
    kFaultBadPose = 1u << 3,     // isPose() says no
    kFaultOutOfReach = 1u << 4,  // beyond kReach radii of a known workspace
    kFaultOverSpeed = 1u << 5,   // kOverSpeed_m_s; once off, anything above kSlowEnough_m_s
    kFaultDeviceLost = 1u << 6,  // kDeviceReady is not set
    kFaultHandOff = 1u << 7,     // kDeviceHandOn is not set
    kFaultNotFocused = 1u << 8,  // by command: CommandKind::focus
    // Never faults: only reasons why the force has not begun.
    kWaitsForSmallForce = 1u << 9,
    kWaitsOffWall = 1u << 10,
    // A fault again. By command: CommandKind::fault.
    kFaultInjected = 1u << 11,
};
struct FaultText {
    Fault bit;
    const char* name;  // one word
    const char* text;  // what happened, for a person
};
// Every bit, lowest first.
std::span<const FaultText> faultTexts() noexcept;

// Force begins once the model has asked for no more than kSmallForce_n for kSettle_s, then rises over
// kStartRamp_s.
inline constexpr double kSmallForce_n = 0.2, kSettle_s = 0.020, kStartRamp_s = 1.5;
// After a fault it falls over kFade_s: with the tick that sees the fault, zero within 20 ms.
inline constexpr double kFade_s = 0.015;
// Without anything new from the device it falls from kStaleFrom_s on, so that it is gone when the silence
// becomes a fault. A shorter silence costs a dip.
inline constexpr double kStaleFrom_s = 0.008, kStaleFade_s = 0.010, kStaleInput_s = 0.020;
// A hand in a puncture stays below 0.2 m/s, a reach through the air below 1. Hysteresis: the force returns
// only to a slow hand.
inline constexpr double kOverSpeed_m_s = 1.0, kSlowEnough_m_s = 0.3;
// In radii of the workspace: no mechanism gets there.
inline constexpr double kReach = 1.5;

enum class ForceStage : std::uint8_t {
    waiting,  // no force; `awaited` says for what
    rising,   // the start ramp, or back from a short silence
    on,
    fading,  // a fault: falling to zero
    off      // a fault: zero until re-armed
};

struct SafetyState {
    ForceStage stage = ForceStage::waiting;
    double level = 0.0;         // share of the force that is sent
    std::uint32_t faults = 0;   // latched Fault bits
    std::uint32_t awaited = 0;  // Fault bits that keep `waiting` waiting
    bool focused = true;        // by command: the session is seen and the headset worn
    double settled_s = 0.0;     // time for which all has been well while waiting
    bool placed = false;        // there has been a fresh good pose
    Vec3 grip_m{0.0};           // its place, device frame
    double silence_s = 0.0;     // since then
    double speed_m_s = 0.0;     // on the way to it
};

// A rotation and a place that can be: finite, unit length within what single precision leaves, within 10 m.
bool isPose(const Pose&) noexcept STYLET_NONBLOCKING;

// All below: haptics thread, noexcept, no allocation, in this order each tick.
// The Fault bits that stand against force in this tick, as far as the device and the focus go.
std::uint32_t checkDevice(SafetyState&, const DeviceProfile&, const DeviceState&,
                          double dt_s) noexcept STYLET_NONBLOCKING;
// Moves stage and level. `unmet`: all bits of this tick; `force_n`: what the device would get at level 1,
// `wall_n` the wall's part of it.
void stepSafety(SafetyState&, std::uint32_t unmet, double force_n, double wall_n,
                double dt_s) noexcept STYLET_NONBLOCKING;
// The explicit act. It counts only once the force is gone; the force then waits, and rises anew.
void rearm(SafetyState&) noexcept STYLET_NONBLOCKING;
void hashSafety(patient::StateHash&, const SafetyState&) noexcept STYLET_NONBLOCKING;

// A soft wall around the workspace, device frame, within the last kWallShare of its radius: force inward and
// the energy in it. Nothing where the workspace is unknown.
inline constexpr double kWallShare = 0.1;
struct WallForce {
    Vec3 force_n{0.0};
    double energy_j = 0.0;
};
WallForce workspaceWall(const DeviceProfile&, const Vec3& grip_m) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
