// The PostgreSQL database of a training centre, which collects the attempts of many stores. It has one
// schema, `stylet`. A connecting program creates or migrates it. The tables match those of the store. The
// attempts' files are in the database as well, split into parts:
//   attempt, metric, event, file      as in the store (packaging/guide/records.md), keyed by the attempt's id
//   file_part                         attempt, path, part from 0, content of at most 1 MiB
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/records/store.h"
#include "base/errors.h"

namespace stylet::records {

// The database cannot be reached, or the connection was lost. The operation had no effect and may be retried.
struct CentreUnreachable : EnvironmentError {
    using EnvironmentError::EnvironmentError;
};

// Single-threaded. Throws CentreUnreachable, or std::runtime_error if the database refuses a request.
class Centre {
  public:
    // `database` is a libpq connection string. `connected` receives the socket after connecting, and -1
    // when the connection ends. Shutting the socket down interrupts pending database calls.
    explicit Centre(const std::string& database, std::function<void(int)> connected = {});
    ~Centre();
    Centre(const Centre&) = delete;
    Centre& operator=(const Centre&) = delete;

    // Stores the attempt in one transaction. An attempt that is already there is not changed. Throws
    // DataError if a file no longer matches its stored checksum.
    void insert(const StoredAttempt&, const std::vector<StoredFile>&);
    void erase(const std::string& id);

  private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

// Returns false if built without PostgreSQL. The constructor of Centre then throws.
bool hasCentre();

}  // namespace stylet::records
