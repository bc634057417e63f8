// Files of a cache: each can be made again, and several programs may write the same one at the same time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>

namespace stylet::patient {

// Makes the folder too. Whole or not at all, under a name of its own, FILE.DIGITS, then renamed: who has the
// old one open reads it to its end. Throws DataError with the reason, and leaves nothing. Not flushed: a
// machine that loses power may tear it, so the reader must check what it reads.
void writeCacheFile(const std::filesystem::path& file,
                    std::initializer_list<std::span<const std::byte>> parts);

// Removes what killed programs left of that: NAME.DIGITS, for `name` or any, untouched for an hour. A younger
// one may be being written.
void sweepLeftovers(const std::filesystem::path& folder, const std::string& name = {});

}  // namespace stylet::patient
