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
    // All on the device's thread. What open() or exchange() returned ready for, final from then on.
    virtual const DeviceProfile& profile() const noexcept = 0;

    // All below may block, each call at most `kDriverDeadline_ns`: a long job (firmware) is cut into
    // exchanges. What they throw counts as failed.

    // Finds and claims the hardware. Returns the stage reached: absent, failed (with `why`), or on the way to
    // ready.
    virtual DeviceStage open(std::string& why) = 0;
    // One exchange: sends the force, takes the newest state. `state` comes with the last pose and buttons,
    // the ready and hand bits set and fresh = 0: set fresh when it is new; clear the hand's bit where the
    // device has a dead-man and nobody holds it (the ready bit follows the stage). Returns the stage after
    // it, `why` saying what is waited for; failed or absent means that the connection is gone. The force is
    // zero at every stage but ready.
    virtual DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) = 0;
    // Zero force where the bus still listens, then lets go. On every way out, a failed open() included.
    virtual void close() noexcept = 0;
};

inline constexpr std::int64_t kDriverDeadline_ns = 100'000'000;

}  // namespace stylet::haptics
