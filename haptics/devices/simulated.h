// A device without hardware: a hand of infinite strength that follows a trace, whatever the force.
#pragma once

#include "haptics/device.h"
#include "haptics/trace.h"

namespace stylet::haptics {

class SimulatedDevice final : public HapticDevice {
  public:
    // `start_ns` is the loop time at which the trace begins. The trace must outlive the device.
    SimulatedDevice(const Trace&, std::int64_t start_ns, const DeviceProfile& = {});
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t now_ns) noexcept override;
    void send(const Vec3& force_n) noexcept override { force_n_ = force_n; }
    const Vec3& force() const noexcept { return force_n_; }

  private:
    const Trace* trace_;
    std::int64_t start_ns_;
    DeviceProfile profile_;
    std::size_t cursor_ = 0;
    Vec3 force_n_{0.0};
};

}  // namespace stylet::haptics
