// The files of an attempt's folder: their sums, and what a kill has left of them. Inside this folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

inline constexpr const char* kWriting = ".writing";  // locked by who writes the attempt

// Cuts the files of frames at their last whole frame. Throws patient::DataError.
std::vector<CutFile> cutTails(const std::filesystem::path& folder);

// What is wrong with a file that was stored so, in a line that names it; empty when nothing is.
std::string damageOf(const std::filesystem::path& folder, const StoredFile& stored);

}  // namespace stylet::records
