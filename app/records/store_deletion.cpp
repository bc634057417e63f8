// Deletes attempts: their folders, their rows, and what the database and its log still hold of them.
#include <fmt/core.h>

#include "app/records/attempt_rows.h"
#include "app/records/disk_linux.h"
#include "app/records/sql.h"
#include "app/records/store.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kReserveBytes = 1 << 20;

}  // namespace

std::size_t Store::eraseTrainee(const std::string& trainee) {
    return translateErrors([&] {
        std::size_t count = 0;
        withReserve([&] { count = markForDeletion(trainee); });  // deleting also needs some free space
        deleteMarked();
        ensureReserve();
        return count;
    });
}

// Marks the folder for deletion and, if asked, queues the deletion for the centre. The caller deletes the
// row.
void Store::doom(const std::string& id, bool at_centre) {
    if (isBeingWritten(id)) throw DataError(attemptFolder(id), "attempt", "is being written");
    execute(*database_, "INSERT INTO doomed (folder) VALUES (?)", id);
    execute(*database_, "DELETE FROM outbox WHERE kind = 'attempt' AND what = ?", id);
    // Ask the centre to erase the attempt, even if it is not recorded as sent. It may be in transmission
    // right now.
    if (at_centre) execute(*database_, "INSERT INTO outbox (kind, what) VALUES ('erase', ?)", id);
}

void Store::discard(const std::string& id) {
    translateErrors([&] {
        withReserve([&] { markForDiscard(id); });  // deleting also needs some free space
        deleteMarked();
        ensureReserve();
    });
}

void Store::markForDiscard(const std::string& id) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    const StoredAttempt attempt = readAttempt(id);
    if (attempt.state == AttemptState::running)
        throw DataError(attemptFolder(id), "attempt", "is being written");
    if (countsInStatistics(attempt))
        throw DataError(attemptFolder(id), "attempt",
                        "enters the statistics: it counts and cannot be discarded");
    // Neither ending the program by force nor editing the index must make a failed exam disappear.
    if ((attempt.state == AttemptState::cut_short || attempt.imported) && attempt.info.difficulty == "exam")
        throw DataError(attemptFolder(id), "attempt",
                        "is an exam that was cut short or imported: it is kept");
    doom(id, !attempt.imported);  // at the centre, the id of a copy may be the original
    execute(*database_, "DELETE FROM attempt WHERE id = ?", id);
    addToLog(fmt::format("discarded attempt {}: {}, scenario {}, {} ticks", id, stateText(attempt),
                         attempt.info.scenario, attempt.result ? attempt.result->ticks : 0));
    change.commit();
}

std::size_t Store::markForDeletion(const std::string& trainee) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    indexUnknownFolders();  // a damaged index must not hide an attempt from its deletion
    std::size_t count = 0;
    for (const std::string& id :
         selectTexts(*database_, "SELECT id FROM attempt WHERE trainee = ?", trainee)) {
        // The row is damaged: its id names no folder of this store. It is only deleted with the other rows
        // below.
        if (!isAttemptId(id)) continue;
        ++count;
        doom(id, true);
    }
    execute(*database_, "DELETE FROM attempt WHERE trainee = ?", trainee);
    change.commit();
    return count;
}

// Best effort: without enough free space the store works without a reserve.
void Store::ensureReserve() const {
    const fs::path file = folder_ / kReserve;
    if (fs::exists(file)) return;
    try {
        const std::vector<unsigned char> room(kReserveBytes, 0xff);
        DiskFile(file).write(room);
    } catch (const DataError&) {
        std::error_code ignored;
        fs::remove(file, ignored);
    }
}

// Completes deletions that eraseTrainee() began, even in a process that crashed. A row of `doomed` stays
// until its folder is gone.
void Store::deleteMarked() {
    const std::vector<std::string> folders = selectTexts(*database_, "SELECT folder FROM doomed");
    if (folders.empty()) return;
    for (const std::string& id : folders)
        if (isAttemptId(id)) fs::remove_all(attemptFolder(id));
    syncFolder(folder_ / "attempts");
    // Makes sure that neither the database file nor its log still contains deleted data.
    database_->exec("VACUUM");
    if (queryInt("PRAGMA wal_checkpoint(TRUNCATE)") != 0)
        throw DataError(file_, "log",
                        "another process is reading the store: deleted data is gone from the index, but "
                        "remains in its log until the store is opened alone");
    for (const std::string& id : folders)
        execute(*database_, "DELETE FROM doomed WHERE folder = ?", id);
}

}  // namespace stylet::records
