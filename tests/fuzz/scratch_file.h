// For parsers that read a file: a file in a temporary folder that is deleted when the process exits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace fuzz {

// A folder in memory if there is one, because a disk is a hundred times slower.
inline const std::filesystem::path& scratchFolder() {
    static const bool in_memory =
        std::filesystem::is_directory("/dev/shm") && setenv("TMPDIR", "/dev/shm", 1) == 0;
    static const stylet::test::TempFolder folder;
    static_cast<void>(in_memory);
    return folder.path();
}

inline std::filesystem::path scratchFile(const char* name, const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path file = scratchFolder() / name;
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return file;
}

}  // namespace fuzz
