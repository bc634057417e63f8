// Live input from a real device, in place of the script.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/trainer/attempt/commands.h"
#include "haptics/devices/clutch.h"
#include "haptics/devices/devices.h"
#include "haptics/devices/polled.h"

namespace stylet::trainer {

inline constexpr const char* kReplayDevice = "replay";  // the name for `--device`: input from a file

class LiveDevice {
  public:
    // Starts the device. Throws DataError if makeDriver() does. The clock is used on the device's
    // thread.
    LiveDevice(const std::string& kind, const haptics::DeviceOptions&, const haptics::Clock&);
    // The same with a driver created by the caller. The caller must keep alive whatever the driver uses.
    LiveDevice(const std::string& kind, std::unique_ptr<haptics::Driver>, const haptics::Clock&);
    // Waits until the device is ready (plugged in, permitted, loaded, homed) and reports progress on
    // stderr. Returns false if `given_up` returns true first.
    bool waitUntilReady(const std::function<bool()>& given_up);
    // Reports changes of the device's state on stderr.
    void tellNews();
    // The device itself: poses of the grip, no clutch.
    haptics::HapticDevice& bare() { return device_; }
    const haptics::DeviceProfile& profile() const { return device_.profile(); }
    // Current grip pose. Call only before the loop uses the device.
    Pose grip();
    // The device for the loop. A device that senses no orientation gets the orientation of `held` and a
    // clutch from here on (haptics/devices/clutch.h).
    haptics::HapticDevice& aimed(const Pose& held);
    // Changes the tool pose of a clutched device (ClutchedDevice::hold). No effect on a device that senses
    // orientation. One thread.
    void hold(const Pose& held);
    // Button mapping without the clutch button. The second function returns it as text. Call after aimed().
    UserButtons buttons() const;
    std::string describeButtons() const;
    // What the user must do to re-arm, as text; includes the key, which works with any device.
    std::string rearmAct() const;
    // Session thread. Text typed since the last call.
    std::string typed();
    // Sends zero force and stops the device.
    void stop() { device_.stop(); }

  private:
    std::string kind_, told_;
    bool typing_ = true;  // stdin has not ended
    haptics::Clock clock_;
    haptics::PolledDevice device_;
    std::optional<haptics::ClutchedDevice> clutched_;
};

}  // namespace stylet::trainer
