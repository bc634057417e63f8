// What is known of the devices people have, by name.
#pragma once

#include <span>
#include <string_view>

#include "haptics/device.h"

namespace stylet::haptics {

std::span<const DeviceProfile> deviceProfiles() noexcept;
// nullptr: no such device.
const DeviceProfile* findProfile(std::string_view name) noexcept;

}  // namespace stylet::haptics
