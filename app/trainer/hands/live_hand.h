// Live input from a real device, in place of the script.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>

#include "app/trainer/attempt/commands.h"
#include "app/trainer/session/input_names.h"
#include "haptics/devices/clutch.h"
#include "haptics/devices/devices.h"
#include "haptics/devices/polled.h"

namespace stylet::trainer {

// What the buttons of two controllers do (controllerButtons()).
extern const UserButtons kControllerFunctions;

class LiveDevice {
  public:
    // Starts the device. Throws DataError if makeDriver() does. The clock is used on the device's
    // thread.
    LiveDevice(const std::string& kind, const haptics::DeviceOptions&, const haptics::Clock&);
    // Same with a driver created by the caller. Everything that the driver uses must outlive this object.
    LiveDevice(const std::string& kind, std::unique_ptr<haptics::Driver>, const haptics::Clock&);
    // Waits until the device is ready (plugged in, permitted, loaded, homed) and reports progress on
    // stderr. Returns false if `given_up` returns true first.
    bool waitUntilReady(const std::function<bool()>& given_up);
    // Reports changes of the device's state on stderr.
    void reportStateChanges();
    // The device without clutch, with grip poses.
    haptics::HapticDevice& bare() { return device_; }
    const haptics::DeviceProfile& profile() const { return device_.profile(); }
    bool exertsForce() const { return !haptics::isInputOnly(profile()); }
    // Current grip pose. Call only before the loop uses the device.
    Pose grip();
    // The device for the loop. If the device senses no orientation, it gets the orientation of `tool_pose`
    // and, from now on, a clutch (haptics/devices/clutch.h).
    haptics::HapticDevice& loopDevice(const Pose& tool_pose);
    // Changes the tool pose of a device with a clutch (ClutchedDevice::setTool). No effect on a device that
    // senses orientation. Call from one thread only.
    void setTool(const Pose& tool_pose);
    // Button mapping without the clutch button, and without re-arming if the device exerts no force. The
    // second function returns it as text for an attempt of this course. Call after loopDevice().
    UserButtons buttons() const;
    std::string describeButtons(training::Course) const;
    // Describes how the user re-arms. Includes the key, which works with any device. Empty for a device
    // without force, which has nothing to re-arm.
    std::string rearmAct() const;
    // Session thread. Text typed since the last call.
    std::string typed();
    // Sends zero force and stops the device.
    void stop() { device_.stop(); }

  private:
    std::string kind_, reported_state_;
    bool reported_slow_ = false;  // with the reported state
    bool typing_ = true;          // stdin has not ended
    haptics::Clock clock_;
    haptics::PolledDevice device_;
    std::optional<haptics::ClutchedDevice> clutched_;
};

// Opens a device and waits until it is ready. Throws DataError if the user ends the program before that.
std::unique_ptr<LiveDevice> openReadyDevice(const std::string& kind, const haptics::DeviceOptions&,
                                            const haptics::Clock&);
// Throws DataError with all names if `name` is neither a haptic device nor one of `others`.
void checkDeviceName(const std::string& name, std::initializer_list<const char*> others);
// The replay device needs a trace file, and no other device may have one. Throws UsageError.
void checkTraceOption(const std::string& kind, const std::filesystem::path& trace);

}  // namespace stylet::trainer
