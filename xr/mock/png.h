#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xrmock {

// The bytes of a PNG file. The rows are of 8-bit red, green, blue, alpha, top row first; alpha is left out.
// Throws std::runtime_error.
std::string encodePng(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& rgba);

// The file appears under its name when it is complete. Throws std::runtime_error.
void writeFile(const std::string& file_name, const std::string& bytes);

}  // namespace xrmock
