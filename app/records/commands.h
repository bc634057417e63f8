// `stylet records ...`: what is said of a store, and asked of it.
#pragma once

#include <filesystem>
#include <string>

namespace stylet::records {

struct RecordsOptions {
    std::filesystem::path store;
    std::string trainee;        // list, export: all when empty
    std::string id;             // show
    std::filesystem::path out;  // export
    std::string database;       // sync
};

// The exit status: 0 done, 1 something is not as it should be and was said. Throw patient::DataError.
int listAttempts(const RecordsOptions&);
int showAttempt(const RecordsOptions&);
int recoverStore(const RecordsOptions&);
int exportStore(const RecordsOptions&);
int deleteTrainee(const RecordsOptions&);
int syncStore(const RecordsOptions&);

}  // namespace stylet::records
