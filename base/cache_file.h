// Cache files. Each file can be rebuilt, and several programs may write the same file at the same time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>

namespace stylet {

// Also creates the folder. Writes to a temporary file FILE.DIGITS and renames it, so a reader sees all of the
// old file or all of the new one. A program that has the old file open can read it to its end. On failure,
// throws DataError with the reason and leaves no file behind. The data is not flushed to disk, so a power
// failure can truncate the file. The reader must check what it reads.
void writeCacheFile(const std::filesystem::path& file,
                    std::initializer_list<std::span<const std::byte>> parts);

// Removes temporary files left by killed programs: NAME.DIGITS, for `name` or for any name if it is empty.
// Only files untouched for an hour are removed; a newer one may still be being written.
void removeStaleTemporaryFiles(const std::filesystem::path& folder, const std::string& name = {});

}  // namespace stylet
