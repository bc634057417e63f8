// `stylet devices`: which devices there are, in which state, with which limits.
#pragma once

#include <string>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

// As text for a person, or JSON: {"devices": [{"name", "what", "built", "missing", "limits", "found":
// [{"place", "what", "problem"}]}]}, unknown limits null. Throws patient::DataError when a file in the
// options is bad.
std::string describeDevices(const haptics::DeviceOptions&, bool json);

}  // namespace stylet::trainer
