// The PostgreSQL database of a training centre, which collects the attempts of many stores. It has one
// schema, `stylet`, which a connecting program creates or migrates. The tables match the store's; the files
// are stored in the database as well, in parts:
//   attempt, metric, event, file      as in the store (README.md), keyed by the attempt's id
//   file_part                         attempt, path, part from 0, content: at most 1 MiB each
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

// The database cannot be reached, or the connection was lost. The operation had no effect and may be
// retried.
struct Unreachable : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Single-threaded. Throws Unreachable, or std::runtime_error if the database refuses a request.
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
    void keep(const StoredAttempt&, const std::vector<StoredFile>&);
    void erase(const std::string& id);

  private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

// Returns false if built without PostgreSQL. The constructor of Centre then throws.
bool hasCentre();

}  // namespace stylet::records
