// Corrects a device's tip position by the offset that the registration has found (stylus_from_tip_m).
#pragma once

#include "haptics/tools/device.h"

namespace stylet::trainer {

class TippedDevice final : public haptics::HapticDevice {
  public:
    // The device must outlive it.
    TippedDevice(haptics::HapticDevice& device, const Vec3& stylus_from_tip_m)
        : device_(&device), stylus_from_tip_m_(stylus_from_tip_m) {}

    const haptics::DeviceProfile& profile() const noexcept override { return device_->profile(); }
    haptics::DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override {
        haptics::DeviceState state = device_->read(now_ns);
        state.device_from_stylus.position_m = state.device_from_stylus * stylus_from_tip_m_;
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { device_->send(force_n); }

  private:
    haptics::HapticDevice* device_;
    Vec3 stylus_from_tip_m_;
};

}  // namespace stylet::trainer
