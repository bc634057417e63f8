// Measuring what a Falcon's newton comes to: steady forces down each axis in turn, and a person who reads a
// kitchen scale. The forces pass the output stage, like every other.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "haptics/device.h"
#include "haptics/devices/falcon_calibration.h"
#include "haptics/loop.h"

namespace stylet::haptics::falcon {

struct CalibrationTalk {
    std::function<void(const std::string&)> say;
    // Called again and again, never waits: a number once it has been typed.
    std::function<std::optional<double>()> heard;
    std::function<bool()> stop;  // the user has had enough
};

// Grams on the scale at each force; three forces on each of three axes. `device` must run with a calibration
// of ones. A fault ends the force and begins the axis anew, the finished ones stay; where nothing is asked of
// the device it costs nothing. Throws patient::DataError: the device failed again and again (named), the
// readings do not fit, or it was stopped.
Calibration calibrate(HapticDevice& device, const Clock&, const CalibrationTalk&);

}  // namespace stylet::haptics::falcon
