// A PostgreSQL of the test's own: in a temporary folder, on a socket in it, with no port and no password.
#pragma once

#include <string>

#include "tests/support/temp_folder.h"

namespace stylet::test {

class Postgres {
  public:
    static bool isInstalled();
    Postgres();  // made and started; throws std::runtime_error where the server's programs are missing
    ~Postgres();
    Postgres(const Postgres&) = delete;
    Postgres& operator=(const Postgres&) = delete;

    void start();
    void stop();  // at once: whoever is connected is thrown out, as after a crash
    std::string url() const;

  private:
    int run(const std::string& command) const;

    TempFolder folder_;
    std::string programs_, as_;
};

}  // namespace stylet::test
