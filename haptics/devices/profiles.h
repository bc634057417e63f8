// Profiles of known devices, by name.
#pragma once

#include <span>
#include <string_view>

#include "haptics/tools/device.h"

namespace stylet::haptics {

std::span<const DeviceProfile> deviceProfiles() noexcept;
// Returns nullptr for an unknown name.
const DeviceProfile* findProfile(std::string_view name) noexcept;

}  // namespace stylet::haptics
