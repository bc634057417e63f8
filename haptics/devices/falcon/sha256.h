// SHA-256 (FIPS 180-4), to record which file a user loaded into a device.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace stylet::haptics {

// 64 lower-case hexadecimal digits.
std::string computeSha256(std::span<const std::uint8_t>);

}  // namespace stylet::haptics
