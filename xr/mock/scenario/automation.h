// Input state that a test sets through the functions of XR_EXT_conformance_automation. After the test's first
// call to one of them, the buttons and axes of the scenario's devices are ignored. Poses that the test has
// not set still come from the scenario.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "scenario/devices.h"

namespace xrmock {

struct AutomatedValue {
    double value = 0;
    std::int64_t changed_ns = 0;  // XrTime
};

struct AutomatedDevice {
    bool active = false;
    std::string profile;
    std::map<std::string, AutomatedValue, std::less<>> values;    // by component, "input/select/click"
    std::map<std::string, Pose, std::less<>> stage_from_sources;  // "input/grip/pose"
};

struct Automation {
    bool in_control = false;
    std::array<AutomatedDevice, kUserCount> devices;

    AutomatedDevice& acquireDevice(User user) {
        in_control = true;
        return devices[static_cast<std::size_t>(user)];
    }
};

}  // namespace xrmock
