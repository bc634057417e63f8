// SQL statements of the store, and the translation of their errors. Internal to this folder.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>
#include <sqlite3.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::records {

inline constexpr const char* kReserve = ".reserve";  // deleted to make room when the disk is full

// SQLite calls it an I/O error if it has no room for its shared memory.
inline bool isDiskFull(const SQLite::Exception& e) {
    return (e.getErrorCode() & 0xff) == SQLITE_FULL || e.getExtendedErrorCode() == SQLITE_IOERR_SHMSIZE;
}

// Binds the values in order and runs the statement, which can then be run again. NaN becomes NULL.
template <typename... Values>
void run(SQLite::Statement& statement, const Values&... values) {
    SQLite::bind(statement, values...);
    statement.exec();
    statement.reset();
}

template <typename... Values>
void execute(SQLite::Database& database, const char* sql, const Values&... values) {
    SQLite::Statement statement(database, sql);
    run(statement, values...);
}

// The first column of every selected row.
template <typename... Values>
std::vector<std::string> selectTexts(SQLite::Database& database, const char* sql, const Values&... values) {
    SQLite::Statement row(database, sql);
    SQLite::bind(row, values...);
    std::vector<std::string> texts;
    while (row.executeStep())
        texts.push_back(row.getColumn(0).getString());
    return texts;
}

// Turns any error into a DataError that names the store's file.
template <typename Act>
auto Store::translateErrors(Act act) const {
    try {
        return act();
    } catch (const SQLite::Exception& e) {
        throw DataError(file_, "database", e.what());
    } catch (const std::filesystem::filesystem_error& e) {
        throw DataError(e.path1().empty() ? folder_ : e.path1(), "file", e.code().message());
    } catch (const std::logic_error& e) {  // for example from stoull, for a text that is not a number
        throw DataError(file_, "database", std::string("a row cannot be read: ") + e.what());
    }
}

// Runs `act`. If the disk is full, deletes the reserve, runs `act` again and returns true.
template <typename Act>
bool Store::withReserve(const Act& act) {
    try {
        act();
        return false;
    } catch (const SQLite::Exception& e) {
        if (!isDiskFull(e) || !std::filesystem::remove(folder_ / kReserve)) throw;
    }
    act();
    return true;
}

}  // namespace stylet::records
