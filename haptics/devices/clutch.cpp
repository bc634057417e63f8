#include "haptics/devices/clutch.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "haptics/output/safety.h"

namespace stylet::haptics {

namespace {

constexpr double kTurn_rad_per_s = 1.0, kMove_m_per_s = 0.1;
// Room between the path's entry and the wall, for placing a tool on the skin.
constexpr double kRoomOutside_m = 0.011;

}  // namespace

void stepClutch(ClutchState& s, const ClutchSettings& settings, const Pose& tool, double dt_s,
                DeviceState& state) noexcept {
    const Vec3 grip_m = state.device_from_stylus.position_m;
    const bool ready = (state.flags & kDeviceReady) != 0;
    if (!s.has_pose && ready) {
        s.tip_m = grip_m;
        s.has_pose = true;
    }
    const bool engaged = ready && (state.buttons & settings.button) == 0;
    if (engaged && !s.engaged) s.tip_from_grip_m = s.tip_m - grip_m;
    s.engaged = engaged;
    if (engaged) s.tip_m = grip_m + s.tip_from_grip_m;
    const double rise = settings.force_ramp_s > 0.0 ? dt_s / settings.force_ramp_s : 1.0;
    s.force_share = engaged ? std::min(1.0, s.force_share + rise) : 0.0;
    state.device_from_stylus = {tool.rotation, s.tip_m + tool.position_m};
    state.grip_at_m = grip_m;
    state.force_share = s.force_share;
    state.flags |= kDeviceClutch;
}

Pose moveToward(const Pose& now, const Pose& wanted, double dt_s) noexcept {
    const double cosine = std::min(1.0, std::fabs(glm::dot(now.rotation, wanted.rotation)));
    const double angle_rad = 2.0 * std::acos(cosine), step_rad = kTurn_rad_per_s * dt_s;
    const Vec3 motion_m = wanted.position_m - now.position_m;
    const double length_m = std::sqrt(glm::dot(motion_m, motion_m)), step_m = kMove_m_per_s * dt_s;
    Pose next = wanted;
    if (angle_rad > step_rad)
        next.rotation = glm::normalize(glm::slerp(now.rotation, wanted.rotation, step_rad / angle_rad));
    if (length_m > step_m) next.position_m = now.position_m + motion_m * (step_m / length_m);
    return next;
}

Pose alignWithPath(const DeviceProfile& profile, const Pose& patient_from_needle) noexcept {
    // The columns of the rotation are the device's axes in the patient frame.
    const Vec3 z = patient_from_needle.direction({0.0, 0.0, 1.0});
    const Vec3 front(0.0, 1.0, 0.0), head(0.0, 0.0, 1.0);
    const Vec3 up = std::fabs(glm::dot(z, front)) < 0.9 ? front : head;
    const Vec3 y = glm::normalize(up - z * glm::dot(z, up));
    const Quat patient_from_device = glm::quat_cast(glm::dmat3(glm::cross(y, z), y, z));
    const double reach_m = (1.0 - kWallShare) * profile.workspace_radius_m - kRoomOutside_m;
    const Vec3 entry_device = profile.workspace_centre_m + Vec3(0.0, 0.0, reach_m);
    return {patient_from_device, patient_from_needle.position_m - patient_from_device * entry_device};
}

ClutchedDevice::ClutchedDevice(HapticDevice& inner, const ClutchSettings& settings, const Pose& tool)
    : inner_(&inner), settings_(settings), tool_(tool), target_tool_(tool) {}

DeviceState ClutchedDevice::read(std::int64_t now_ns) noexcept {
    const double dt_s = std::max(0.0, double(now_ns - last_ns_) * 1e-9);
    Pose wanted;
    if (requested_tool_.read(wanted)) target_tool_ = wanted;
    tool_ = moveToward(tool_, target_tool_, dt_s);
    DeviceState state = inner_->read(now_ns);
    stepClutch(state_, settings_, tool_, dt_s, state);
    last_ns_ = now_ns;
    return state;
}

}  // namespace stylet::haptics
