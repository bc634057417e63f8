// `stylet devices`: lists the devices with their state and limits.
#pragma once

#include <string>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

// Returns readable text, or JSON: {"devices": [{"name", "what", "built", "missing", "limits", "found":
// [{"place", "what", "problem"}]}]}. Unknown limits are null. Throws DataError if a file in the options is
// invalid.
std::string describeDevices(const haptics::DeviceOptions&, bool json);

}  // namespace stylet::trainer
