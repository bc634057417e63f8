// What a trainee may take away, and a study may read: plain files with their checksums.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

struct Exported {
    std::size_t attempts = 0;
    std::vector<std::string> left_out;  // attempts that still run, by id
    std::vector<std::string> damage;    // files that are not what was stored: exported as they are
};

// Into `folder`, made or empty:
//   attempts.csv, metrics.csv, events.csv   a line each, by the attempt's id (README.md, the store's tables)
//   attempts/ID/                            the attempt's files, and attempt.json: all of the above of this
//   one checksums.csv                           path, bytes, crc32 of every file of this export
// A text that a spreadsheet would take for a formula has a ' before it. All trainees when `trainee` is empty.
// Throws patient::DataError.
Exported exportAttempts(const Store&, const std::string& trainee, const std::filesystem::path& folder);

}  // namespace stylet::records
