// File format of the driver's pipeline cache, with a checksum. A driver checks only its own header. The data
// behind the header is machine code, so damaged data must not reach the driver.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stylet::render {

inline constexpr std::size_t kMaxCacheBytes = std::size_t(256) << 20;

std::vector<std::uint8_t> encodeCacheFile(std::span<const std::uint8_t> from_driver);

// Returns the driver's data inside `file`, or nothing if the file is damaged or not a cache file.
std::span<const std::uint8_t> decodeCacheFile(std::span<const std::uint8_t> file);

}  // namespace stylet::render
