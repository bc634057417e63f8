// The store: every attempt of a training site, stored on its local disk first. It has one SQLite file as
// index and one folder per attempt:
//   store.sqlite          attempts, metrics, events (WAL); the guide's records.md has the schema
//   attempts/ID/          the files that `stylet run --out` writes: record/, pictures, exports
// An attempt's record is the truth. The index repeats facts of it, for lists and for the training centre: it
// is filled from the record by finish() and by recovery, and opening a store adds attempts that it lacks.
// Data that finish() has acknowledged survives a crash and a power failure. When the store is opened, it
// recovers attempts whose writer ended without finish(): it cuts their files at the last whole frame, marks
// them "cut short", and reports this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/records/disk_linux.h"
#include "app/records/record.h"

namespace SQLite {
class Database;
}

namespace stylet::records {

// Metadata of an attempt. `trainee` is a pseudonym (checkTrainee); the store contains no real names.
struct AttemptInfo {
    std::string trainee, device, patient, scenario, difficulty, program_version;
    std::uint64_t patient_digest = 0, seed = 0;
    double dt_s = 0.001, device_gain = 1.0;
    std::optional<double> registration_rms_m{};  // for a device registered in the headset's room
};

enum class AttemptState { running, done, cut_short };
std::string_view stateName(AttemptState);  // "running", "done", "cut_short"

// The facts of an attempt's record that the index has too. A list of attempts comes from the index and has,
// of the result, only target_hit, aborted, total, ticks, score_version and metrics.
struct StoredAttempt {
    std::string id;
    AttemptInfo info;
    std::string started_utc;  // "2026-11-21T20:15:00.123Z"
    AttemptState state = AttemptState::running;
    std::optional<AttemptResult> result;  // only if done
    std::vector<EventRow> events;         // in the order of adding
    std::filesystem::path folder;
    // Its folder was copied into the store: the index existed already and had not begun this attempt. A file
    // in the folder (kImportedMark) repeats the mark, so that it survives the loss of the index.
    bool imported = false;
};

// True for an attempt that began with the ticks of an earlier one (`stylet run --from`). Its event "retry"
// names that attempt.
bool isRestarted(const StoredAttempt&);
// True for an attempt that enters statistics: it is done, and neither aborted, restarted nor imported.
bool countsInStatistics(const StoredAttempt&);
// True for an exam that was cut short after a decisive event (training::isDecisive). It has no score, and
// counts as begun and not passed.
bool isUnfinishedExam(const StoredAttempt&);
// For people: "running", "done", "aborted", "restarted", "imported", "cut short", "cut short, not passed".
std::string_view stateText(const StoredAttempt&);

// One line of the store's log: what was removed from it, and when. It names no trainee.
struct LogEntry {
    std::string utc, text;
};

// Converts a record, as loadRecordHead() returns it. `folder`: of the attempt. An attempt with a result is
// done, any other was cut short.
StoredAttempt makeStoredAttempt(const Record&, const std::filesystem::path& folder);

// Compares attempts as the index lists them with their records, for example because someone edited the
// database. Returns one line per attempt that differs, and one line for all records that cannot be read.
// Reads the record.json of each attempt.
std::vector<std::string> findAlteredRows(const std::vector<StoredAttempt>&);

// A repaired file of an attempt that was cut short, relative to the attempt's folder.
struct TruncatedFile {
    std::filesystem::path file;
    std::uint64_t ticks = 0;            // in the whole frames, which are kept
    std::uint64_t truncated_bytes = 0;  // behind the last whole frame
    bool header_incomplete = false;     // the file ends inside its header: nothing of it can be read
};

struct RecoveredAttempt {
    std::string id;
    std::vector<TruncatedFile> files;
    std::string unreadable{};  // why its record cannot be read; empty: it can, or there is none yet
};

// A file of a finished attempt, relative to the attempt's folder.
struct StoredFile {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::uint32_t crc32 = 0;
    friend bool operator==(const StoredFile&, const StoredFile&) = default;
};

// Reads the file. Also calls `visit`, if any, for each part of at most 1 MiB, in order.
StoredFile computeChecksum(const std::filesystem::path& folder, const std::filesystem::path& file,
                           const std::function<void(std::span<const char>)>& visit = {});
std::vector<StoredFile> computeChecksums(const std::filesystem::path& folder);  // all files, sorted by path

// A message for the training centre that is still to be sent (outbox.h).
struct OutboxEntry {
    enum class Kind { attempt, erase };
    std::uint64_t number = 0;
    Kind kind = Kind::attempt;
    std::string attempt_id;  // does not identify the trainee
    unsigned tries = 0;      // failed tries
    std::string error{};     // of the last failed try
};

// "attempt ID was cut short: record/inputs.bin keeps 1250 ticks, 312 torn bytes cut off"
std::string describe(const RecoveredAttempt&);

// Accepts 1 to 64 letters, digits, '.', '_' and '-', of which the first and the last are a letter or digit.
// So a pseudonym is no option, no hidden file and no folder such as "..". Throws DataError with the reason.
void checkTrainee(const std::string& trainee);

// Used by the session thread or a command-line tool. Several processes may open one store. Every function
// throws DataError if the disk refuses. The store then does not contain the refused data.
class Store {
  public:
    // Creates the store if there is none, migrates an older schema, withdraws the access of group and others
    // from the store's own files and folders, and recovers attempts that were cut short. Refuses a folder
    // that is an export or another program's, and a store made by a newer program.
    explicit Store(const std::filesystem::path& folder);
    ~Store();
    Store(Store&&) noexcept;
    Store& operator=(Store&&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    // The attempts recovered when this store was opened, oldest first. Later openings list them only as cut
    // short.
    const std::vector<RecoveredAttempt>& recovered() const { return recovered_; }
    // One line for each of these: permissions that were withdrawn, a lost index that was filled again, an
    // imported attempt, a recovered attempt, a finished attempt with damaged files that was added to the
    // index, and a step that failed. The next opening retries such a step.
    std::vector<std::string> openingMessages() const;
    // Folders under attempts/ that are not in the index, because they have no readable record of that id.
    // They are never modified.
    std::vector<std::filesystem::path> unknownFolders() const;

    // Begins an attempt, creates its folder and returns its id. Only this store may write the attempt, until
    // finish() or the end of the process. The caller writes its record, with this id, into folder/record.
    std::string begin(const AttemptInfo&);
    std::filesystem::path attemptFolder(const std::string& id) const;
    // Removes an attempt that never reached a tick, as if it had not begun.
    void abandon(const std::string& id);
    // Fills the index from the attempt's record, which must have this id and a result. Returns when the rows
    // and every file of the folder are on the disk.
    void finish(const std::string& id);

    // Oldest first. Empty trainee: all.
    std::vector<StoredAttempt> attempts(const std::string& trainee = "") const;
    StoredAttempt attempt(const std::string& id) const;

    // The files of a finished or cut-short attempt, sorted by path.
    std::vector<StoredFile> files(const std::string& id) const;
    // Throws DataError if the attempt's record.json is no longer as it was stored. It is the only file of a
    // record that has no checksum of its own.
    void checkRecord(const std::string& id) const;
    // Checks the index and all files of finished attempts. Returns one line per damaged item; empty if
    // every byte is as stored.
    std::vector<std::string> damage() const;

    // Deletes the rows and folders of all attempts of a trainee from the disk and returns their number.
    // Throws while one of them is being written. Also queues the deletion for the centre. If an error occurs
    // after that, the next opening completes the deletion. Accepts any text, because an older store may
    // contain a pseudonym that is refused today.
    std::size_t eraseTrainee(const std::string& trainee);

    // Deletes an attempt that enters no statistics. Refuses any other, and an exam that was cut short or
    // imported, so that no failure disappears. In the same transaction, a line is added to the store's log
    // and the deletion is queued for the centre, except of an imported attempt: the centre may have the
    // original. If an error occurs after that, the next opening completes the deletion.
    void discard(const std::string& id);
    // What discard() has removed, oldest first.
    std::vector<LogEntry> log() const;

    // The queued entries, oldest first. An entry is queued in the same transaction as the change that it
    // reports.
    std::vector<OutboxEntry> outbox() const;
    void markSent(const OutboxEntry&);                            // sent: removes it from the outbox
    void markFailed(const OutboxEntry&, const std::string& why);  // failed: stays in the outbox

  private:
    void open();
    void checkIsStore() const;
    void migrate();
    std::size_t makeStorePrivate() const;
    FileLock makeFolder(const std::string& id) const;
    bool isBeingWritten(const std::string& id) const;
    void checkOpen(const std::string& id) const;

    int queryInt(const char* sql) const;
    void insertRunning(const std::string& id, const std::string& started_utc, const AttemptInfo&);
    StoredAttempt readAttempt(const std::string& id) const;
    StoredAttempt loadOwnRecord(const std::string& id) const;
    void indexRecord(const StoredAttempt&);
    void storeChecksums(const std::string& id);
    void storeMissingChecksums();
    void markImportedFolders();
    void finalizeAttempt(const std::string& id);
    void addToLog(const std::string& text);

    // store_recovery.cpp
    void recover();
    void recoverAttempt(const std::string& id);
    void recoverLocked(const std::string& id);
    void indexUnknownFolders();
    bool indexUnknownFolder(const std::filesystem::path&, bool imported);

    // store_deletion.cpp
    std::size_t markForDeletion(const std::string& trainee);
    void markForDiscard(const std::string& id);
    void doom(const std::string& id, bool at_centre);
    void deleteMarked();
    void ensureReserve() const;

    // sql.h
    template <typename Act>
    auto translateErrors(Act) const;
    template <typename Act>
    bool withReserve(const Act&);

    std::filesystem::path folder_, file_;
    std::unique_ptr<SQLite::Database> database_;
    std::map<std::string, FileLock> open_;  // attempts this store writes
    std::vector<RecoveredAttempt> recovered_;
    std::vector<std::string> indexed_;       // messages on attempts that the index lacked
    std::vector<std::string> failed_steps_;  // and files found damaged
    std::string tightened_;                  // what the opening did about permissions; empty: nothing
};

}  // namespace stylet::records
