#include "haptics/devices/clutch.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "haptics/safety.h"

namespace stylet::haptics {

void stepClutch(ClutchState& s, const ClutchSettings& settings, const Quat& device_from_needle, double dt_s,
                DeviceState& state) noexcept {
    const Vec3 grip_m = state.device_from_stylus.position_m;
    const bool ready = (state.flags & kDeviceReady) != 0;
    if (!s.placed && ready) {
        s.tip_m = grip_m;
        s.placed = true;
    }
    const bool engaged = ready && (state.buttons & settings.button) == 0;
    if (engaged && !s.engaged) s.tip_from_grip_m = s.tip_m - grip_m;
    s.engaged = engaged;
    if (engaged) s.tip_m = grip_m + s.tip_from_grip_m;
    const double rise = settings.force_back_s > 0.0 ? std::max(dt_s, 0.0) / settings.force_back_s : 1.0;
    s.force_share = engaged ? std::min(1.0, s.force_share + rise) : 0.0;
    state.device_from_stylus = {device_from_needle, s.tip_m};
}

Pose placeAlong(const DeviceProfile& profile, const Pose& patient_from_needle, double before_m) noexcept {
    // Columns: the device's axes in the patient.
    const Vec3 z = patient_from_needle.direction({0.0, 0.0, 1.0});
    const Vec3 front(0.0, 1.0, 0.0), head(0.0, 0.0, 1.0);
    const Vec3 up = std::fabs(glm::dot(z, front)) < 0.9 ? front : head;
    const Vec3 y = glm::normalize(up - z * glm::dot(z, up));
    const Quat patient_from_device = glm::quat_cast(glm::dmat3(glm::cross(y, z), y, z));
    const Vec3 entry_device =
        profile.workspace_centre_m + Vec3(0.0, 0.0, profile.workspace_radius_m - before_m);
    return {patient_from_device, patient_from_needle.position_m - patient_from_device * entry_device};
}

ClutchedDevice::ClutchedDevice(HapticDevice& inner, const ClutchSettings& settings,
                               const Quat& device_from_needle)
    : inner_(&inner),
      settings_(settings),
      profile_(inner.profile()),
      reach_centre_m_(profile_.workspace_centre_m),
      reach_m_(kReach * profile_.workspace_radius_m),
      device_from_needle_(device_from_needle) {
    profile_.workspace_radius_m = kUnknown;
    turned_.publish(device_from_needle);
}

DeviceState ClutchedDevice::read(std::int64_t now_ns) noexcept {
    turned_.read(device_from_needle_);
    DeviceState state = inner_->read(now_ns);
    const Vec3 out_m = state.device_from_stylus.position_m - reach_centre_m_;
    // False where the reach is unknown.
    if (std::sqrt(glm::dot(out_m, out_m)) > reach_m_) state.flags &= ~std::uint32_t(kDeviceReady);
    stepClutch(state_, settings_, device_from_needle_, double(now_ns - last_ns_) * 1e-9, state);
    last_ns_ = now_ns;
    return state;
}

void ClutchedDevice::send(const Vec3& force_n) noexcept {
    inner_->send(force_n * state_.force_share);
}

}  // namespace stylet::haptics
