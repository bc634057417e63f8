// Reads or writes a file in one go. On failure it throws a DataError that ends with the system's reason:
// "FILE: file: cannot be written: No space left on device".
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace stylet {

// The file's bytes. Throws DataError if it does not exist, is larger than `max_bytes` or cannot be read
// completely.
std::string readWholeFile(const std::filesystem::path& file, std::size_t max_bytes);

// Atomic: writes beside `file` and renames, so a reader sees all of the old file or all of the new one,
// even after a crash. Writes directly into anything that is not a regular file (a pipe, a link). Only one
// writer at a time; for files shared between programs see cache_file.h.
void writeWholeFile(const std::filesystem::path& file, std::string_view bytes);

// Not atomic. Use it if the file or its folder is renamed into place afterwards.
void writeFile(const std::filesystem::path& file, std::string_view bytes);

}  // namespace stylet
