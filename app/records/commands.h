// The `stylet records ...` commands: list, show, recover, export, delete, discard, log, sync.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

struct RecordsOptions {
    std::filesystem::path store;
    std::string trainee;        // for list, export; empty: all
    std::string id;             // for show, discard
    std::filesystem::path out;  // for export
    std::string database;       // for sync
};

// Opens an existing store and prints its opening messages to stderr, each prefixed with "PROGRAM: ". Throws
// DataError if there is no store, because opening would create one.
Store openExistingStore(const std::filesystem::path& folder, const char* program = "stylet");

// Prints findAlteredRows() in the same way, and returns it.
std::vector<std::string> reportAlteredRows(const std::vector<StoredAttempt>&, const char* program = "stylet");

// These return the exit status. 0: success, 1: a problem was found and reported. They throw DataError.
int listAttempts(const RecordsOptions&);
int showAttempt(const RecordsOptions&);
int recoverStore(const RecordsOptions&);
int exportStore(const RecordsOptions&);
int deleteTrainee(const RecordsOptions&);
int discardAttempt(const RecordsOptions&);
int printLog(const RecordsOptions&);
int syncStore(const RecordsOptions&);

}  // namespace stylet::records
