// Opening a store: attempts that were cut short are recovered, and attempts that the index lacks are added.
#include <SQLiteCpp/Savepoint.h>
#include <fmt/core.h>

#include <algorithm>

#include "app/records/attempt_files.h"
#include "app/records/sql.h"
#include "app/records/store.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

// Returns true if the attempt's folder contains no data. The program that created it then ended before it
// stored the attempt's database row, so the id was never used and the folder can be deleted.
bool isEmptyAttemptFolder(const fs::path& folder) {
    if (!fs::is_directory(folder)) return false;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != kLockFile) return false;
    return true;
}

}  // namespace

void Store::recover() {
    for (const std::string& id :
         selectTexts(*database_, "SELECT id FROM attempt WHERE state = 'running' ORDER BY number"))
        try {
            translateErrors([&] { recoverAttempt(id); });
        } catch (const std::exception& e) {
            failed_steps_.push_back("attempt " + id + " was cut short and cannot be recovered: " + e.what());
        }
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    for (const fs::path& folder : unknownFolders())
        try {
            if (isEmptyAttemptFolder(folder)) fs::remove_all(folder);
        } catch (const fs::filesystem_error& e) {
            failed_steps_.push_back(folder.string() + " cannot be searched: " + e.code().message());
        }
    indexUnknownFolders();
    change.commit();
}

// Indexes a running attempt whose writer has ended. Holds the database's write lock, as begin() and finish()
// do while they change an attempt's state and its lock file.
void Store::recoverAttempt(const std::string& id) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    if (selectTexts(*database_, "SELECT id FROM attempt WHERE state = 'running' AND id = ?", id).empty() ||
        isBeingWritten(id))
        return;
    recoverLocked(id);
    change.commit();
}

void Store::recoverLocked(const std::string& id) {
    const fs::path folder = attemptFolder(id);
    RecoveredAttempt found{id, {}};
    std::optional<StoredAttempt> attempt;
    try {
        if (fs::exists(recordFile(folder))) attempt = loadOwnRecord(id);
    } catch (const DataError& e) {
        found.unreadable = e.what();
    }
    const bool done = attempt && attempt->result;
    // The files of a done attempt were complete before its result was written. If one is torn now, it was
    // damaged later: truncating it would hide the damage.
    std::vector<std::string> damaged;
    if (done)
        damaged = findTornFiles(folder);
    else
        found.files = truncateTornTails(folder);
    fs::remove(folder / kLockFile);
    if (fs::exists(folder)) syncTree(folder);
    if (attempt) indexRecord(*attempt);
    if (!done) execute(*database_, "UPDATE attempt SET state = 'cut_short' WHERE id = ?", id);
    finalizeAttempt(id);
    if (!done) recovered_.push_back(std::move(found));
    for (const std::string& file : damaged)
        failed_steps_.push_back("attempt " + id + " is finished but damaged, and was not changed: " + file);
}

// Adds attempts that the index lacks. If it never had an attempt, it was lost and is filled again. Otherwise
// their folders were copied here, or their rows were removed, and they are marked as imported. A folder with
// that mark is always imported. A folder without a readable record of that id is left alone. A folder that
// fails does not affect the others. If one fails while a lost index is filled again, the next opening
// continues that.
void Store::indexUnknownFolders() {
    const bool lost_index = queryInt("SELECT count(*) FROM sqlite_sequence WHERE name = 'attempt'") == 0;
    std::size_t count = 0, failures = 0;
    for (const fs::path& folder : unknownFolders())
        try {
            SQLite::Savepoint one_folder(*database_, "one_folder");
            const bool added = fs::is_directory(folder) && indexUnknownFolder(folder, !lost_index);
            one_folder.release();
            if (!added) continue;
            ++count;
            if (!lost_index)
                indexed_.push_back("attempt " + folder.filename().string() +
                                   " was not recorded by this store: it is listed as imported, and enters no "
                                   "statistics");
        } catch (const std::exception& e) {
            // SQLite has rolled back the whole transaction, for example because the disk is full.
            if (sqlite3_get_autocommit(database_->getHandle()) != 0) throw;
            const auto* error = dynamic_cast<const SQLite::Exception*>(&e);
            if (error && isDiskFull(*error)) throw;  // see withReserve()
            ++failures;
            failed_steps_.push_back("attempts/" + folder.filename().string() +
                                    " cannot be indexed: " + e.what());
        }
    if (!lost_index || count == 0) return;
    const std::string text = fmt::format(
        "the index was lost and is filled again from the records of {} "
        "attempt{}; the results are only as trustworthy as these files",
        count, count == 1 ? "" : "s");
    indexed_.push_back(file_.string() + ": " + text);
    addToLog(text);
    if (failures > 0) execute(*database_, "DELETE FROM sqlite_sequence WHERE name = 'attempt'");
}

// Returns false if the folder is no attempt, or one that is being written or deleted.
bool Store::indexUnknownFolder(const fs::path& folder, bool imported) {
    const std::string id = folder.filename().string();
    if (isBeingWritten(id) ||
        !selectTexts(*database_, "SELECT folder FROM doomed WHERE folder = ?", id).empty())
        return false;
    if (!fs::exists(recordFile(folder))) return false;
    const StoredAttempt attempt = loadOwnRecord(id);
    if (imported) markImported(folder);
    insertRunning(id, attempt.started_utc, attempt.info);
    recoverLocked(id);
    return true;
}

std::vector<fs::path> Store::unknownFolders() const {
    return translateErrors([&] {
        std::vector<fs::path> unknown;
        for (const auto& entry : fs::directory_iterator(folder_ / "attempts"))
            if (selectTexts(*database_, "SELECT id FROM attempt WHERE id = ?",
                            entry.path().filename().string())
                    .empty())
                unknown.push_back(entry.path());
        std::sort(unknown.begin(), unknown.end());
        return unknown;
    });
}

}  // namespace stylet::records
