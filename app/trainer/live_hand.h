// The user's hand on a real device, in place of a script's.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/trainer/commands.h"
#include "haptics/devices/clutch.h"
#include "haptics/devices/devices.h"
#include "haptics/devices/polled.h"

namespace stylet::trainer {

inline constexpr const char* kReplayDevice = "replay";  // of --device: a hand from a file

class LiveDevice {
  public:
    // Starts the device. Throws patient::DataError: what makeDriver() refuses. The clock is used on the
    // device's thread.
    LiveDevice(const std::string& kind, const haptics::DeviceOptions&, const haptics::Clock&);
    // The same with a driver made by the caller, who keeps what it needs.
    LiveDevice(const std::string& kind, std::unique_ptr<haptics::Driver>, const haptics::Clock&);
    // Until it is ready, saying on stderr what is waited for: plugged in, permitted, loaded, homed. False
    // when `given_up` says so first.
    bool waitUntilReady(const std::function<bool()>& given_up);
    // Says on stderr what became of it since the last time.
    void tellNews();
    // As it is, the grip's own place and no clutch.
    haptics::HapticDevice& bare() { return device_; }
    const haptics::DeviceProfile& profile() const { return device_.profile(); }
    // Where the grip is now. Before the loop has the device.
    patient::Pose grip();
    // The device, to be given to the loop. One that senses no orientation has the tool's from here on, and a
    // clutch (haptics/devices/clutch.h).
    haptics::HapticDevice& aimed(const patient::Pose& held);
    // Such a device holds the tool so from now on (ClutchedDevice::hold); any other is as its user holds it.
    // One thread.
    void hold(const patient::Pose& held);
    // What its buttons mean, none of them the clutch, and so in words. Once aimed.
    UserButtons buttons() const;
    std::string describeButtons() const;
    // In words, with the key that does it on any device.
    std::string rearmAct() const;
    // What was typed since the last call. Session thread.
    std::string typed();
    // Zero force, and the end.
    void stop() { device_.stop(); }

  private:
    std::string kind_, told_;
    bool typing_ = true;  // stdin has not ended
    haptics::Clock clock_;
    haptics::PolledDevice device_;
    std::optional<haptics::ClutchedDevice> clutched_;
};

}  // namespace stylet::trainer
