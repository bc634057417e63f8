// SHA-256 (FIPS 180-4): which file a user loaded into a device goes into the record.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace stylet::haptics {

// 64 lower-case hexadecimal digits.
std::string sha256Of(std::span<const std::uint8_t>);

}  // namespace stylet::haptics
