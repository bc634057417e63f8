// `stylet devices --calibrate FILE`: measures a Falcon's force in newtons with a kitchen scale. Writes the
// calibration file that --calibration reads.
#pragma once

#include <filesystem>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

// Prompts on stdout and reads the answers from stdin. Throws DataError.
void calibrateFalcon(const haptics::DeviceOptions&, const std::filesystem::path& file);

}  // namespace stylet::trainer
