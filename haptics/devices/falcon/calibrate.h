// Measures the true force of a Falcon: presses with steady forces along each axis in turn while a person
// reads a kitchen scale. The forces pass through the output stage (haptics/output/output.h), which limits
// them as it does all others.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "haptics/devices/falcon/falcon_calibration.h"
#include "haptics/loop/loop.h"
#include "haptics/tools/device.h"

namespace stylet::haptics::falcon {

struct CalibrationPrompts {
    std::function<void(const std::string&)> print;
    // Polled, must not block. Returns a number once one has been typed.
    std::function<std::optional<double>()> readNumber;
    std::function<bool()> stop;  // true if the user wants to stop
};

// The user reads the scale in grams for three forces along each of three axes. `device` must run with a
// calibration of 1 along each axis. A fault removes the force and restarts the current axis; finished axes
// are kept. While no force is requested, a fault has no consequence. Throws EnvironmentError with the fault's
// text if the device keeps failing, and DataError if the readings do not lie on a line through zero, or if
// the user stopped.
Calibration calibrate(HapticDevice& device, const Clock&, const CalibrationPrompts&);

}  // namespace stylet::haptics::falcon
