#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xrmock {

// Encodes 8-bit RGBA rows, top row first, as a PNG file. Alpha is dropped. Throws std::runtime_error.
std::string encodePng(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& rgba);

// Writes the file atomically: it appears under its name only when complete. Throws std::runtime_error.
void writeFile(const std::string& file_name, const std::string& bytes);

}  // namespace xrmock
