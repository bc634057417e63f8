// A training centre's PostgreSQL: what many stores have sent, one schema (`stylet`), made and brought up to
// date by who connects. Beside the store's tables it holds the files themselves, in parts:
//   attempt, metric, event, file      as in the store (README.md), by the attempt's id
//   file_part                         attempt, path, part from 0, content: at most 1 MiB each
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

// The database cannot be reached, or went away: what was under way has not happened, and may be tried again.
struct Unreachable : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// One thread. Throws Unreachable; std::runtime_error when the database refuses what it is told.
class Centre {
  public:
    // `database` as libpq names it. `connected` is told the socket while there is one, then -1: shut down, it
    // ends what waits for the database.
    explicit Centre(const std::string& database, std::function<void(int)> connected = {});
    ~Centre();
    Centre(const Centre&) = delete;
    Centre& operator=(const Centre&) = delete;

    // All of it or nothing; what is there already stays as it is. Throws patient::DataError when a file is
    // not what was stored.
    void keep(const StoredAttempt&, const std::vector<StoredFile>&);
    void erase(const std::string& id);

  private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

// Built without PostgreSQL there is no centre, and the constructor says so.
bool hasCentre();

}  // namespace stylet::records
