#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xrmock {

// Writes rows of 8-bit red, green, blue, top row first. The file appears under its name when it is complete.
// Throws std::runtime_error.
void writePng(const std::string& file_name, std::uint32_t width, std::uint32_t height,
              const std::vector<std::uint8_t>& rgb);

}  // namespace xrmock
