// Paths of files and folders, as text.
#pragma once

#include <filesystem>

namespace stylet {

// "a/b/" and "a/b" name the same folder. Returns the latter, so that filename() and parent_path() work.
inline std::filesystem::path withoutSlash(const std::filesystem::path& folder) {
    return folder.has_filename() ? folder : folder.parent_path();
}

}  // namespace stylet
