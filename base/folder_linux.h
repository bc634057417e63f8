// Folders for output.
#pragma once

#include <filesystem>
#include <string>

namespace stylet {

// Creates the folder if needed and checks that it is writable. Throws DataError with the folder, its purpose
// `what` and the reason: "FOLDER: --out: cannot be made: Not a directory".
void requireFolder(const std::filesystem::path& folder, const std::string& what);

}  // namespace stylet
