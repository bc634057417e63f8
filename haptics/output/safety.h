// Decides when a device may exert force: the preconditions, the force ramps, and a named bit for every
// reason why there is no force.
#pragma once

#include <cstdint>
#include <span>

#include "base/hash.h"
#include "haptics/tools/device.h"

namespace stylet::haptics {

// Fault bits. A set bit stays until the run is re-armed (CommandKind::rearm). All but kFaultRingFull remove
// the force.
enum Fault : std::uint32_t {
    kFaultBadForce = 1u << 0,    // a model's force, energy or tissue motion is not finite
    kFaultStaleInput = 1u << 1,  // no fresh valid pose for kStaleInput_s
    kFaultRingFull = 1u << 2,    // set by the loop only: the session's pace must not enter the hashed state
    kFaultBadPose = 1u << 3,     // isPose() returned false
    kFaultOutOfReach = 1u << 4,  // beyond kMaxReachRadii radii of a known workspace
    kFaultOverSpeed = 1u << 5,   // above kOverSpeed_m_s; while not armed, above kSlowEnough_m_s
    kFaultDeviceLost = 1u << 6,  // kDeviceReady is not set
    kFaultHandOff = 1u << 7,     // kDeviceHandOn is not set
    kFaultNotFocused = 1u << 8,  // by command: CommandKind::focus
    // Never faults, only reasons why the force has not started.
    kWaitsForSmallForce = 1u << 9,
    kWaitsOffWall = 1u << 10,
    // A fault, set by CommandKind::fault.
    kFaultInjected = 1u << 11,
    // The device leapt away from the needle in the body (simulation.h). Set until it is back or outside.
    kFaultAwayFromNeedle = 1u << 12,
    kFaultHostLate = 1u << 13,  // in place of device-lost or stale-input if kDeviceHostLate is set
};
struct FaultText {
    Fault bit;
    const char* name;  // one word
    const char* text;  // description for the user
};
// Every bit, lowest first.
std::span<const FaultText> faultTexts() noexcept;

// The force starts once no fault bit is set and the wanted force has stayed at or below kSmallForce_n for
// kSettle_s. It then rises over kStartRamp_s.
inline constexpr double kSmallForce_n = 0.2, kSettle_s = 0.020, kStartRamp_s = 1.5;
// After a fault the force falls over kFade_s. Including the tick that detects the fault, it is zero within
// 20 ms.
inline constexpr double kFade_s = 0.015;
// Without new device data the force falls from kStaleFrom_s on, so that it is zero when the silence becomes
// a fault. A shorter silence only causes a dip in the force.
inline constexpr double kStaleFrom_s = 0.008, kStaleFade_s = 0.010, kStaleInput_s = 0.020;
// A hand stays below 0.2 m/s in a puncture and below 1 m/s when reaching through air. Hysteresis: the force
// returns only when the hand is slow.
inline constexpr double kOverSpeed_m_s = 1.0, kSlowEnough_m_s = 0.3;
// In radii of the workspace. No mechanism reaches that far.
inline constexpr double kMaxReachRadii = 1.5;

enum class ForceStage : std::uint8_t {
    waiting,  // no force; `awaited` lists the reasons
    rising,   // start ramp, or recovering from a short silence
    on,
    fading,  // a fault: falling to zero
    off      // a fault: zero until re-armed
};

struct SafetyState {
    ForceStage stage = ForceStage::waiting;
    double level = 0.0;         // fraction of the force that is sent
    std::uint32_t faults = 0;   // latched Fault bits
    std::uint32_t awaited = 0;  // Fault bits that prevent leaving `waiting`
    bool focused = true;        // by command: the session is visible and the headset worn
    double settled_s = 0.0;     // time spent in `waiting` without any such bit
    bool has_pose = false;      // there has been a fresh valid pose
    Vec3 grip_m{0.0};           // grip position of that pose, device frame
    double silence_s = 0.0;     // time since that pose
    double speed_m_s = 0.0;     // mean speed between the last two fresh valid poses
};

// True for a plausible pose: finite, unit rotation within single-precision error, position within 10 m.
// False for NaN.
bool isPose(const Pose&) noexcept STYLET_NONBLOCKING;

// All below: haptics thread, noexcept, no allocation, called in this order in each tick.
// Returns the fault bits that forbid force in this tick because of the device or the focus.
std::uint32_t checkDevice(SafetyState&, const DeviceProfile&, const DeviceState&,
                          double dt_s) noexcept STYLET_NONBLOCKING;
// Updates stage and level. `fault_bits`: all fault bits of this tick. `force_n`: the force the device would
// get at level 1. `wall_n`: the wall's part of it.
void stepSafety(SafetyState&, std::uint32_t fault_bits, double force_n, double wall_n,
                double dt_s) noexcept STYLET_NONBLOCKING;
// The same for a device without force, which has none to lose: only a bug of the model is latched. The loss
// of the device, once it has been there, is a fault for as long as it lasts: there is nothing to re-arm. Only
// a needle that was left behind is awaited. The stage stays `waiting`.
void reportWithoutForce(SafetyState&, std::uint32_t fault_bits) noexcept STYLET_NONBLOCKING;
// Re-arms after a fault. Works only once the force is zero. The force then waits and rises as at the start.
void rearm(SafetyState&) noexcept STYLET_NONBLOCKING;
void hashSafety(StateHash&, const SafetyState&) noexcept STYLET_NONBLOCKING;

// A soft wall around the workspace, device frame, in the outermost kWallShare of its radius. Returns the
// inward force and its energy. Zero if the workspace is unknown.
inline constexpr double kWallShare = 0.1;
struct WallForce {
    Vec3 force_n{0.0};
    double energy_j = 0.0;
};
WallForce workspaceWall(const DeviceProfile&, const Vec3& grip_m) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
