// The files in an attempt's folder: names, checksums, and repair of files torn by a crash. Internal to this
// folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

inline constexpr const char* kLockFile = ".writing";          // locked by the process that writes the attempt
inline constexpr const char* kImportedMark = "imported.txt";  // in an imported attempt's folder

inline std::filesystem::path recordFile(const std::filesystem::path& attempt_folder) {
    return attempt_folder / "record" / "record.json";
}

// Writes kImportedMark, unless there is one. Throws DataError.
void markImported(const std::filesystem::path& attempt_folder);

// Cuts the frame files at their last whole frame. Throws DataError.
std::vector<TruncatedFile> truncateTornTails(const std::filesystem::path& folder);

// Lists the frame files that do not end with a whole frame, without changing them: one text with name and
// position per file. Throws DataError.
std::vector<std::string> findTornFiles(const std::filesystem::path& folder);

// Returns one line with the file's name and its damage. Empty if the file is still as stored.
std::string findDamage(const std::filesystem::path& folder, const StoredFile& stored);

}  // namespace stylet::records
