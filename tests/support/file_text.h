// Reads a file into a string.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace stylet::test {

// Returns every byte of the file, or an empty string if there is none.
inline std::string readText(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace stylet::test
