// Checksums of the files in an attempt's folder, and repair of files torn by a crash. Internal to this
// folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

inline constexpr const char* kWriting = ".writing";  // locked by the process that writes the attempt

// Cuts the frame files at their last whole frame. Throws DataError.
std::vector<CutFile> cutTails(const std::filesystem::path& folder);

// Returns a line that names the file and its damage, or an empty text if the file still is what was stored.
std::string damageOf(const std::filesystem::path& folder, const StoredFile& stored);

}  // namespace stylet::records
