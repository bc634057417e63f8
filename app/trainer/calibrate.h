// `stylet devices --calibrate FILE`: measures a Falcon's newtons with a kitchen scale and writes what
// --calibration takes.
#pragma once

#include <filesystem>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

// Asks on stdout, listens on stdin. Throws patient::DataError.
void calibrateFalcon(const haptics::DeviceOptions&, const std::filesystem::path& file);

}  // namespace stylet::trainer
