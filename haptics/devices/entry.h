// A supported kind of device: its name and its functions. Each driver defines one in its folder; devices.cpp
// lists them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptics/devices/driver.h"
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

struct FoundDevice {
    std::string kind;     // a DeviceKind's name
    std::string place;    // "/dev/hidraw0", "usb 1-2"
    std::string what;     // the device's own name
    std::string problem;  // what prevents its use and the remedy; empty if nothing does
};

// `find`, `profile` and `make` implement findDevices(), deviceProfile() and makeDriver() for this kind. All
// are null if the kind is missing from this build.
struct DeviceEntry {
    DeviceKind kind;
    void (*find)(const DeviceOptions&, std::vector<FoundDevice>&);
    DeviceProfile (*profile)(const DeviceOptions&);
    std::unique_ptr<Driver> (*make)(const DeviceOptions&, const Clock&);
};

}  // namespace stylet::haptics
