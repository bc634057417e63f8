// Exports attempts as plain files with checksums, for the trainee or for a study.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

struct Exported {
    std::size_t attempts = 0;
    std::vector<std::string> left_out;  // ids of attempts still running
    std::vector<std::string> damage;    // files that differ from what was stored; exported as they are
};

// Writes into `folder`, which must be empty or is created:
//   attempts.csv, metrics.csv, events.csv   one line each, keyed by the attempt's id (columns: README.md)
//   attempts/ID/                            the attempt's files, and attempt.json with all its rows
//   checksums.csv                           path, bytes, crc32 of every file of this export
// Texts that a spreadsheet would evaluate as a formula are prefixed with '. Exports all trainees if
// `trainee` is empty. Throws DataError.
Exported exportAttempts(const Store&, const std::string& trainee, const std::filesystem::path& folder);

}  // namespace stylet::records
