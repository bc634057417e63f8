#include "tests/support/postgres.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace stylet::test {

namespace {

std::string programsFolder() {
    std::error_code none;
    for (const auto& version : std::filesystem::directory_iterator("/usr/lib/postgresql", none))
        if (std::filesystem::exists(version.path() / "bin" / "initdb"))
            return (version.path() / "bin").string();
    return "";
}

}  // namespace

bool Postgres::isInstalled() {
    return !programsFolder().empty();
}

Postgres::Postgres() : programs_(programsFolder()) {
    if (programs_.empty()) throw std::runtime_error("PostgreSQL is not installed (package postgresql)");
    // The server refuses to run as root.
    if (geteuid() == 0) as_ = "runuser -u postgres -- ";
    chmod(folder_.path().c_str(), 0777);
    if (run("initdb -D '" + (folder_ / "data").string() +
            "' -A trust -U stylet -E UTF8 --locale=C --no-sync") != 0)
        throw std::runtime_error("initdb failed");
    start();
}

Postgres::~Postgres() {
    run("pg_ctl -D '" + (folder_ / "data").string() + "' -m immediate -w stop");
    if (!as_.empty()) [[maybe_unused]]
        const int gone = std::system((as_ + "rm -rf '" + (folder_ / "data").string() + "'").c_str());
}

int Postgres::run(const std::string& command) const {
    return std::system(
        (as_ + programs_ + "/" + command + " >'" + (folder_ / "said").string() + "' 2>&1").c_str());
}

void Postgres::start() {
    if (run("pg_ctl -D '" + (folder_ / "data").string() + "' -l '" + (folder_ / "data" / "log").string() +
            "' -o \"-h '' -k '" + folder_.path().string() + "' -F\" -t 120 -w start") != 0)
        throw std::runtime_error("PostgreSQL did not start");
}

void Postgres::stop() {
    run("pg_ctl -D '" + (folder_ / "data").string() + "' -m immediate -w stop");
}

std::string Postgres::url() const {
    return "host=" + folder_.path().string() + " user=stylet dbname=postgres";
}

}  // namespace stylet::test
