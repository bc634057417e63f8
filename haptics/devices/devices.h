// The list of supported devices: which are plugged in, what prevents their use, and their drivers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/devices/clutch.h"
#include "haptics/devices/driver.h"
#include "haptics/devices/falcon/calibrate.h"
#include "haptics/devices/polled.h"
#include "haptics/devices/profiles.h"
#include "haptics/devices/replay.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

// User-supplied files and addresses that some devices need.
struct DeviceOptions {
    std::filesystem::path model{};        // woodenhaptics: JSON file with its dimensions
    std::filesystem::path firmware{};     // falcon: not bundled, its licence forbids it
    std::filesystem::path calibration{};  // falcon: measured calibration
    std::string socket{};                 // bridge: empty for the default path
    std::optional<std::uint16_t> port{};  // inverse3: port of its service, if not the default
    // inverse3: maximum force [N], entered by the user from the data sheet that came with the device. The
    // driver has no built-in value, because the manufacturer publishes none.
    std::optional<double> force_peak_n{};
};

struct DeviceKind {
    const char* name;     // name on the command line
    const char* what;     // description for the user
    const char* missing;  // package missing from this build; null if the driver is built in
};
// In display order.
std::span<const DeviceKind> deviceKinds() noexcept;

struct FoundDevice {
    std::string kind;     // a DeviceKind's name
    std::string place;    // "/dev/hidraw0", "usb 1-2"
    std::string what;     // the device's own name
    std::string problem;  // what prevents its use and the remedy; empty if nothing does
};
// Lists the devices plugged in now. Opens none of them.
std::vector<FoundDevice> findDevices(const DeviceOptions&);

// Returns the profile of a kind of device, as far as it is known before the device is opened. Unknown values
// are NaN. May read the file DeviceOptions::model. Throws DataError.
DeviceProfile profileOfKind(std::string_view kind, const DeviceOptions&);

// Returns the SHA-256 digest of the file DeviceOptions::firmware, or an empty string if no file is named. The
// digest is stored with the attempt. Throws DataError.
std::string firmwareDigest(const DeviceOptions&);

// Creates the driver for PolledDevice. The clock is used on the device's thread. Throws DataError:
// unknown kind, not in this build, or a file that is missing or invalid.
std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions&, const Clock&);

}  // namespace stylet::haptics
