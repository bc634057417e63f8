// A device with a mount transform between the poses that it reports and those that the loop uses.
#pragma once

#include <optional>

#include "haptics/tools/device.h"

namespace stylet::trainer {

// Absent transforms are skipped, not applied as identity. Results then stay equal bit by bit.
struct Mount {
    std::optional<Vec3> stylus_from_tip_m{};     // tip in the reported stylus frame (Registration)
    std::optional<Pose> recorded_from_device{};  // converts poses to the device frame of the record (retry.h)

    Pose apply(Pose device_from_stylus) const noexcept {
        if (stylus_from_tip_m) device_from_stylus.position_m = device_from_stylus * *stylus_from_tip_m;
        return recorded_from_device ? *recorded_from_device * device_from_stylus : device_from_stylus;
    }
};

// Passes forces on unchanged, so a device with force output must not have `recorded_from_device`.
class MountedDevice final : public haptics::HapticDevice {
  public:
    // The device must outlive this object.
    MountedDevice(haptics::HapticDevice& device, const Mount& mount) : device_(&device), mount_(mount) {}

    const haptics::DeviceProfile& profile() const noexcept override { return device_->profile(); }
    haptics::DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override {
        haptics::DeviceState state = device_->read(now_ns);
        state.device_from_stylus = mount_.apply(state.device_from_stylus);
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { device_->send(force_n); }

  private:
    haptics::HapticDevice* device_;
    Mount mount_;
};

}  // namespace stylet::trainer
