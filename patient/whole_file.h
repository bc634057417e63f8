// Files that are read or written in one go. What is refused is a DataError that ends in the system's reason:
// "FILE: file: cannot be written: No space left on device".
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace stylet::patient {

// Its bytes: refused where it is not there, larger than `max_bytes`, or cannot be read to its end.
std::string readWholeFile(const std::filesystem::path& file, std::size_t max_bytes);

// Whole or not at all: written beside `file` and renamed, so that who reads it, or comes after a stop, finds
// all of the old one or all of the new. What is no plain file (a pipe, a link) is written into. Of one writer
// at a time; for files that programs share, see cache_file.h.
void writeWholeFile(const std::filesystem::path& file, std::string_view bytes);

// As it comes, where something larger is put in its place as a whole.
void writeFile(const std::filesystem::path& file, std::string_view bytes);

}  // namespace stylet::patient
