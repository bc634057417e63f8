// The driver's pipeline cache as it lies on disk: sealed, since a driver checks its own header and no more,
// and what is damaged behind it is machine code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stylet::render {

inline constexpr std::size_t kMostCacheBytes = std::size_t(256) << 20;

std::vector<std::uint8_t> sealedCache(std::span<const std::uint8_t> from_driver);

// What the driver gave, inside `file`; empty where the file is not whole or is none.
std::span<const std::uint8_t> cacheIn(std::span<const std::uint8_t> file);

}  // namespace stylet::render
