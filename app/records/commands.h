// The `stylet records ...` commands: list, show, recover, export, delete, sync.
#pragma once

#include <filesystem>
#include <string>

namespace stylet::records {

struct RecordsOptions {
    std::filesystem::path store;
    std::string trainee;        // for list, export; empty: all
    std::string id;             // for show
    std::filesystem::path out;  // for export
    std::string database;       // for sync
};

// Return the exit status: 0 success, 1 a problem was found and reported. Throw DataError.
int listAttempts(const RecordsOptions&);
int showAttempt(const RecordsOptions&);
int recoverStore(const RecordsOptions&);
int exportStore(const RecordsOptions&);
int deleteTrainee(const RecordsOptions&);
int syncStore(const RecordsOptions&);

}  // namespace stylet::records
