// A haptic device as the loop sees it. Drivers are in devices/.
#pragma once

#include <cstdint>

#include "haptics/output.h"

namespace stylet::haptics {

struct DeviceState;

class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual const DeviceProfile& profile() const noexcept = 0;
    // Haptics thread. The newest state; `now_ns` is the loop's time.
    virtual DeviceState read(std::int64_t now_ns) noexcept = 0;
    // Haptics thread. Force in the device frame, N. Called from the output stage's one call site.
    virtual void send(const Vec3& force_n) noexcept = 0;
};

}  // namespace stylet::haptics
