// A private PostgreSQL server in a temporary folder. It listens on a socket there, without port or password.
#pragma once

#include <string>

#include "tests/support/temp_folder.h"

namespace stylet::test {

class Postgres {
  public:
    static bool isInstalled();
    Postgres();  // creates and starts it; throws std::runtime_error if the server's programs are missing
    ~Postgres();
    Postgres(const Postgres&) = delete;
    Postgres& operator=(const Postgres&) = delete;

    void start();
    void stop();  // at once: all clients are disconnected, as after a crash
    std::string url() const;

  private:
    int run(const std::string& command) const;

    TempFolder folder_;
    std::string programs_, as_;
};

}  // namespace stylet::test
