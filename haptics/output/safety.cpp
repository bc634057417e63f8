#include "haptics/output/safety.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stylet::haptics {

namespace {

constexpr std::array<FaultText, 14> kTexts{{
    {kFaultBadForce, "bad-force",
     "a force model computed a value that is not a number: report this as a bug"},
    {kFaultStaleInput, "stale-input", "the device sent no new data for 20 ms"},
    {kFaultRingFull, "ring-full", "the session was too slow: ticks were not recorded"},
    {kFaultBadPose, "bad-pose", "the device reported an impossible pose"},
    {kFaultOutOfReach, "out-of-reach", "the device reported a position that its mechanism cannot reach"},
    {kFaultOverSpeed, "over-speed", "the device moved faster than 1 m/s"},
    {kFaultDeviceLost, "device-lost", "the device is not ready: unplugged, failed or not homed"},
    {kFaultHandOff, "hand-off", "no hand holds the device"},
    {kFaultNotFocused, "not-focused", "the headset is off, or another program has the focus"},
    {kWaitsForSmallForce, "in-contact", "the tool touches the patient: draw it back"},
    {kWaitsOffWall, "at-wall", "the grip is at the end of its reach: move it inward"},
    {kFaultInjected, "injected", "the instructor simulated a device failure"},
    {kFaultAwayFromNeedle, "away-from-needle",
     "the device jumped away from the needle: bring it back or draw it out"},
    {kFaultHostLate, "computer-late",
     "this computer was too busy to serve the device in time: close other programs"},
}};

// No hand is farther from its device than this. A pose beyond it means a device fault.
constexpr double kFarthestPose_m = 10.0;
// Tolerance on the length of a rotation quaternion. Single-precision drivers stay far inside it.
constexpr double kUnitTolerance = 1e-3;
// Tolerance for accumulated time, so that rounding never delays the end of waiting by a tick.
constexpr double kSameTime_s = 1e-9;
constexpr double kZeroLevel = 1e-9;  // a level this small is zero except for rounding
// The wall is softer than any tissue.
constexpr double kWall_n_per_m = 200.0, kWallForce_n = 1.0;

bool isArmed(ForceStage stage) noexcept {
    return stage == ForceStage::rising || stage == ForceStage::on;
}

// Speed over the time since the last fresh pose. A needle in the body checks the distance too
// (findFollowing()).
void updateSpeed(SafetyState& s, const DeviceState& device, bool good, double dt_s) noexcept {
    s.silence_s += dt_s;
    if (device.fresh == 0 || !good) return;
    const Vec3 grip_m = device.grip_m();
    s.speed_m_s = s.has_pose ? glm::distance(grip_m, s.grip_m) / s.silence_s : 0.0;
    s.grip_m = grip_m;
    s.silence_s = 0.0;
    s.has_pose = true;
}

// Returns the bit for a force above kSmallForce_n (or NaN), else 0. There is one bit for the wall and one for
// the tissue.
std::uint32_t largeForceBits(double force_n, double wall_n) noexcept {
    if (force_n <= kSmallForce_n) return 0;
    return wall_n > kSmallForce_n ? kWaitsOffWall : kWaitsForSmallForce;
}

}  // namespace

std::span<const FaultText> faultTexts() noexcept {
    return kTexts;
}

bool isPose(const Pose& pose) noexcept {
    const Vec3& p = pose.position_m;
    const double norm2 = glm::dot(pose.rotation, pose.rotation);
    // NaN fails these comparisons.
    return std::fabs(p.x) <= kFarthestPose_m && std::fabs(p.y) <= kFarthestPose_m &&
           std::fabs(p.z) <= kFarthestPose_m && std::fabs(norm2 - 1.0) <= kUnitTolerance;
}

std::uint32_t checkDevice(SafetyState& s, const DeviceProfile& profile, const DeviceState& device,
                          double dt_s) noexcept {
    // NaN fails these comparisons.
    const bool good = isPose(device.device_from_stylus) && isFinite(device.grip_m()) &&
                      device.share() >= 0.0 && device.share() <= 1.0;
    updateSpeed(s, device, good, dt_s);
    std::uint32_t fault_bits = 0;
    const bool host_late = (device.flags & kDeviceHostLate) != 0;
    if (!good) fault_bits |= kFaultBadPose;
    if ((device.flags & kDeviceReady) == 0) fault_bits |= host_late ? kFaultHostLate : kFaultDeviceLost;
    if ((device.flags & kDeviceHandOn) == 0) fault_bits |= kFaultHandOff;
    if (!s.focused) fault_bits |= kFaultNotFocused;
    if (s.silence_s > kStaleInput_s - kSameTime_s)
        fault_bits |= host_late ? kFaultHostLate : kFaultStaleInput;
    if (s.speed_m_s > (isArmed(s.stage) ? kOverSpeed_m_s : kSlowEnough_m_s)) fault_bits |= kFaultOverSpeed;
    // The comparison is false for an unknown (NaN) radius.
    if (good && glm::distance(device.grip_m(), profile.workspace_centre_m) >
                    kMaxReachRadii * profile.workspace_radius_m)
        fault_bits |= kFaultOutOfReach;
    return fault_bits;
}

void stepSafety(SafetyState& s, std::uint32_t fault_bits, double force_n, double wall_n,
                double dt_s) noexcept {
    if (isArmed(s.stage) && fault_bits != 0) {
        s.faults |= fault_bits;
        s.stage = ForceStage::fading;
    }
    s.awaited = 0;
    switch (s.stage) {
        case ForceStage::waiting:
            s.awaited = fault_bits | largeForceBits(force_n, wall_n);
            s.settled_s = s.awaited == 0 ? s.settled_s + dt_s : 0.0;
            if (s.settled_s > kSettle_s - kSameTime_s) s.stage = ForceStage::rising;
            break;
        case ForceStage::rising:
        case ForceStage::on:
            if (s.silence_s > kStaleFrom_s) {
                s.level = std::max(0.0, s.level - dt_s / kStaleFade_s);
            } else {
                s.level = std::min(1.0, s.level + dt_s / kStartRamp_s);
            }
            s.stage = s.level < 1.0 ? ForceStage::rising : ForceStage::on;
            break;
        case ForceStage::fading:
            s.faults |= fault_bits;
            s.level -= dt_s / kFade_s;
            if (s.level > kZeroLevel) break;
            s.level = 0.0;
            s.stage = ForceStage::off;
            break;
        case ForceStage::off:
            break;
    }
}

void reportWithoutForce(SafetyState& s, std::uint32_t fault_bits) noexcept {
    const std::uint32_t lost = s.has_pose ? fault_bits & kFaultDeviceLost : 0;
    s.faults = ((s.faults | fault_bits) & kFaultBadForce) | lost;
    s.awaited = fault_bits & kFaultAwayFromNeedle;
}

void rearm(SafetyState& s) noexcept {
    if (s.stage != ForceStage::off) return;
    s.stage = ForceStage::waiting;
    s.faults = 0;
    s.settled_s = 0.0;
}

void hashSafety(StateHash& hash, const SafetyState& s) noexcept {
    hash.add(std::uint64_t(s.stage) | std::uint64_t(s.focused) << 8 | std::uint64_t(s.has_pose) << 9 |
             std::uint64_t(s.faults) << 32);
    hash.add(std::uint64_t(s.awaited), s.level, s.settled_s, s.grip_m, s.silence_s, s.speed_m_s);
}

WallForce workspaceWall(const DeviceProfile& profile, const Vec3& grip_m) noexcept {
    const Vec3 out = grip_m - profile.workspace_centre_m;
    const double from_centre = glm::length(out);
    const double in_wall = from_centre - (1.0 - kWallShare) * profile.workspace_radius_m;
    if (!(in_wall > 0.0)) return {};  // also for an unknown radius
    const double stiffness =
        std::min(kWall_n_per_m, 0.25 * valueOrDefault(profile.stiffness_n_per_m, kWeakestStiffness_n_per_m));
    const double pressed = std::min(in_wall, kWallForce_n / stiffness);
    const Vec3 inward = out * (-1.0 / from_centre);
    return {stiffness * pressed * inward,
            0.5 * stiffness * pressed * pressed + kWallForce_n * (in_wall - pressed)};
}

}  // namespace stylet::haptics
