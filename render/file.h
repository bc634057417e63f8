// A small file as a whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace stylet::render {

// Throws patient::DataError when it cannot be read or is longer than `max_bytes`.
std::string readFile(const std::filesystem::path&, std::size_t max_bytes);

}  // namespace stylet::render
