// What a driver for real hardware is: blocking calls on one bus. PolledDevice (polled.h) gives it a thread of
// its own, its state machine and its watchdog, and is the HapticDevice that the loop sees.
#pragma once

#include <cstdint>
#include <string>

#include "haptics/device.h"

namespace stylet::haptics {

// Where a device stands. The names are shown to users.
enum class DeviceStage : std::uint8_t {
    absent,         // nothing plugged in
    opening,        // found, being claimed
    needsFirmware,  // being loaded, or no file was named
    needsHoming,    // waiting for the user to move it to its stops
    ready,
    failed,  // see the reason; tried again with back-off
};

class Driver {
  public:
    virtual ~Driver() = default;
    virtual const DeviceProfile& profile() const noexcept = 0;

    // All below: the device's thread. May block, each call at most `kDriverDeadline_ns` (firmware loading
    // excepted: it has a deadline a chunk and asks `stopping`).

    // Finds and claims the hardware. Returns the stage reached: absent, failed (with `why`), or on the way to
    // ready.
    virtual DeviceStage open(std::string& why) = 0;
    // One exchange: sends the force, takes the newest state. `state.fresh` says whether it is new. Returns
    // the stage after it; failed means that the connection is gone, with `why`.
    virtual DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) = 0;
    // Zero force where the bus still listens, then lets go. On every way out.
    virtual void close() noexcept = 0;
};

inline constexpr std::int64_t kDriverDeadline_ns = 100'000'000;

}  // namespace stylet::haptics
