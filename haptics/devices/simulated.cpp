#include "haptics/devices/simulated.h"

namespace stylet::haptics {

SimulatedDevice::SimulatedDevice(const Trace& trace, std::int64_t start_ns, const DeviceProfile& profile)
    : trace_(&trace), start_ns_(start_ns), profile_(profile) {}

DeviceState SimulatedDevice::read(std::int64_t now_ns) noexcept {
    const TraceSample sample = sampleAt(*trace_, now_ns - start_ns_, cursor_);
    return {.device_from_stylus = sample.device_from_stylus, .buttons = sample.buttons};
}

}  // namespace stylet::haptics
