// The user's hand on a real device, in place of a script's.
#pragma once

#include <functional>
#include <string>

#include "haptics/devices/devices.h"
#include "haptics/devices/polled.h"

namespace stylet::trainer {

class LiveDevice {
  public:
    // Starts the device. Throws patient::DataError: what makeDriver() refuses. The clock is used on the
    // device's thread.
    LiveDevice(const std::string& kind, const haptics::DeviceOptions&, const haptics::Clock&);
    // Until it is ready, saying on stderr what is waited for: plugged in, permitted, loaded, homed. False
    // when `given_up` says so first.
    bool waitUntilReady(const std::function<bool()>& given_up);
    // Says on stderr what became of it since the last time.
    void tellNews();
    haptics::PolledDevice& device() { return device_; }

  private:
    std::string kind_, told_;
    haptics::Clock clock_;
    haptics::PolledDevice device_;
};

}  // namespace stylet::trainer
