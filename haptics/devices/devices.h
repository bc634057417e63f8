// Every device that a user can name: what is plugged in, what stands in the way, and its driver.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/devices/driver.h"
#include "haptics/loop.h"

namespace stylet::haptics {

// Files and addresses of the user's that some devices need.
struct DeviceOptions {
    std::filesystem::path model{};         // woodenhaptics: the JSON file of its dimensions
    std::filesystem::path firmware{};      // falcon: never bundled, its licence forbids it
    std::filesystem::path calibration{};   // falcon: newtons per count, as measured
    std::string socket{};                  // bridge: empty is its usual place
    std::optional<std::uint16_t> port{};   // inverse3: its service's, when not the usual one
    std::optional<double> force_peak_n{};  // inverse3: from its data sheet; none is published
};

struct DeviceKind {
    const char* name;     // as the user gives it
    const char* what;     // for a person
    const char* missing;  // the package that was not there when this was built; null: it can be used
};
// In the order in which they are shown.
std::span<const DeviceKind> deviceKinds() noexcept;

struct FoundDevice {
    std::string kind;     // a DeviceKind's name
    std::string place;    // "/dev/hidraw0", "usb 1-2"
    std::string what;     // as it calls itself
    std::string problem;  // what stands in the way, and its remedy; empty: nothing
};
// What is there now. Nothing is opened.
std::vector<FoundDevice> findDevices(const DeviceOptions&);

// What is known of a kind before it is opened; what is not known is NaN. The model's file may be read.
// Throws patient::DataError.
DeviceProfile profileOfKind(std::string_view kind, const DeviceOptions&);

// SHA-256 of the firmware image that the options name, for the record; empty where they name none. Throws
// patient::DataError.
std::string firmwareDigest(const DeviceOptions&);

// The driver, for PolledDevice. Throws patient::DataError: no such kind, not in this build, or a file that is
// missing or bad. The clock is used on the device's thread.
std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions&, const Clock&);

}  // namespace stylet::haptics
