// Interface of a driver for real hardware: blocking calls on one bus. PolledDevice (polled.h) runs it on a
// separate thread with a state machine and a watchdog, and is the HapticDevice that the loop sees.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "haptics/tools/device.h"

namespace stylet::haptics {

// State of the connection.
enum class DeviceStage : std::uint8_t {
    absent,         // nothing plugged in
    opening,        // found, being claimed
    needsFirmware,  // firmware is being loaded, or no file was given
    needsHoming,    // the user must move it to its stops
    ready,
    failed,  // see the reason; retried with back-off
};
// Names shown to users, in the order of DeviceStage.
inline constexpr std::array<std::string_view, 6> kDeviceStageNames{
    "absent", "opening", "needs firmware", "needs homing", "ready", "failed"};

class Driver {
  public:
    virtual ~Driver() = default;
    // All calls are made on the device's thread. The profile is final once open() or exchange() has returned
    // `ready`.
    virtual const DeviceProfile& profile() const noexcept = 0;

    // All functions below may block for up to `kDriverDeadline_ns`. A long job (firmware) is split over
    // several exchanges. An exception counts as `failed`.

    // Finds and claims the hardware. Returns the stage reached: absent, failed (with `why`), or a stage on
    // the path to ready.
    virtual DeviceStage open(std::string& why) = 0;
    // One exchange: sends the force and reads the newest state. On entry `state` has the last pose and
    // buttons, the ready and hand bits set, and fresh = 0. Set `fresh` if the state is new. Clear the hand
    // bit if the device has a dead-man switch that is not held. The ready bit follows the stage. Returns the
    // stage after the exchange; `why` says what is missing. `failed` or `absent` means the connection is
    // gone. The force is zero in every stage but `ready`.
    virtual DeviceStage exchange(const Vec3& force_n, DeviceState& state, std::string& why) = 0;
    // Sends zero force if the bus still works, then releases the device. Called on every exit, including
    // after a failed open().
    virtual void close() noexcept = 0;
};

inline constexpr std::int64_t kDriverDeadline_ns = 100'000'000;

}  // namespace stylet::haptics
