// Measures the true force of a Falcon: presses with steady forces along each axis in turn while a person
// reads a kitchen scale. The forces pass through the output stage like all others.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "haptics/devices/falcon/falcon_calibration.h"
#include "haptics/loop/loop.h"
#include "haptics/tools/device.h"

namespace stylet::haptics::falcon {

struct CalibrationTalk {
    std::function<void(const std::string&)> say;
    // Polled, must not block. Returns a number once one has been typed.
    std::function<std::optional<double>()> heard;
    std::function<bool()> stop;  // true if the user wants to stop
};

// The user reads the scale in grams for three forces along each of three axes. `device` must run with a
// calibration of ones. A fault removes the force and restarts the current axis; finished axes are kept.
// While no force is requested, a fault has no consequence. Throws DataError if the device keeps
// failing (with the fault's text), if the readings do not fit, or if the user stopped.
Calibration calibrate(HapticDevice& device, const Clock&, const CalibrationTalk&);

}  // namespace stylet::haptics::falcon
