// The store: every attempt of a training site, kept on its local disk first. It has one SQLite file as
// index and one folder per attempt:
//   store.sqlite          attempts, metrics, events (WAL); the guide's records.md has the schema
//   attempts/ID/          the files that `stylet run --out` writes: summary.json, pictures, record/
// Data that finish() has acknowledged survives a crash and a power failure. When the store is opened,
// attempts whose writer has ended are recovered: their files are cut at the last whole frame, they are
// marked "cut short", and the recovery is reported.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/records/disk_linux.h"

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

// The value is in the unit named by `unit`; `points` of at most `most_points`.
struct MetricRow {
    std::string id, name, unit;
    double value = 0.0, points = 0.0, most_points = 0.0;
};

// kind: one of training::kEventKinds (app/training/progress.h).
struct EventRow {
    std::uint64_t tick = 0;
    std::string kind, text;
};

struct AttemptResult {
    bool target_hit = false;
    double total = 0.0;  // score, 0 to 100
    std::uint64_t ticks = 0;
    std::vector<MetricRow> metrics;
};

enum class AttemptState { running, done, cut_short };
std::string_view stateName(AttemptState);  // "running", "done", "cut_short"

struct StoredAttempt {
    std::string id;
    AttemptInfo info;
    std::string started_utc;  // "2026-11-21T20:15:00.123Z"
    AttemptState state = AttemptState::running;
    std::optional<AttemptResult> result;  // only if done
    std::vector<EventRow> events;         // in the order of adding
    std::filesystem::path folder;
};

// A repaired file of an attempt that was cut short, relative to the attempt's folder.
struct CutFile {
    std::filesystem::path file;
    std::uint64_t ticks = 0;      // in whole frames, which are kept
    std::uint64_t cut_bytes = 0;  // behind the last whole frame
    bool headless = false;        // the file ends inside its header: nothing of it can be read
};

struct Recovered {
    std::string id;
    std::vector<CutFile> files;
};
// A file of a finished attempt, relative to the attempt's folder.
struct StoredFile {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::uint32_t crc32 = 0;
};

StoredFile sumOf(const std::filesystem::path& folder, const std::filesystem::path& file);
std::vector<StoredFile> sumsOf(const std::filesystem::path& folder);  // all files, sorted by path

// A message for the training centre that is still to be sent (outbox.h).
struct OutboxEntry {
    enum class Kind { attempt, erase };
    std::uint64_t number = 0;
    Kind kind = Kind::attempt;
    std::string what;     // id of the attempt; does not identify the trainee
    unsigned tries = 0;   // failed tries
    std::string error{};  // of the last failed try
};

// "attempt ID was cut short: record/inputs.bin keeps 1250 ticks, 312 torn bytes cut off"
std::string describe(const Recovered&);

// Accepts letters, digits, '.', '_' and '-', 1 to 64 of them. Throws DataError with the reason.
void checkTrainee(const std::string& trainee);

// Used by the session thread or a command-line tool. Several processes may open one store. Every function
// throws DataError if the disk refuses; the refused data is then not in the store.
class Store {
  public:
    // Creates the store if there is none, migrates an older schema, and recovers attempts that were cut
    // short. Refuses a folder that is not a store, and a store made by a newer program.
    explicit Store(const std::filesystem::path& folder);
    ~Store();
    Store(Store&&) noexcept;
    Store& operator=(Store&&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    // The attempts recovered when this store was opened, oldest first. Later openings list them only as cut
    // short.
    const std::vector<Recovered>& recovered() const { return recovered_; }
    // One line per recovered attempt, and per step that failed when opening. The next opening retries such
    // steps.
    std::vector<std::string> news() const;
    // Folders under attempts/ that are not in the index. They are never modified.
    std::vector<std::filesystem::path> unknownFolders() const;

    // Begins an attempt, creates its folder and returns its id. This store owns the attempt until finish()
    // or the end of the process.
    std::string begin(const AttemptInfo&);
    std::filesystem::path folderOf(const std::string& id) const;
    // Survives a crash at once, and a power failure after finish().
    void add(const std::string& id, const std::vector<EventRow>&);
    // Like add(), but does not wait: returns false and adds nothing while another process is writing.
    bool addAtOnce(const std::string& id, const std::vector<EventRow>&);
    // Removes an attempt that never reached a tick, as if it had not begun.
    void abandon(const std::string& id);
    // Returns when the rows and every file of the folder are on the disk.
    void finish(const std::string& id, const AttemptResult&);

    std::vector<StoredAttempt> attempts(
        const std::string& trainee = "") const;  // oldest first; empty trainee: all
    StoredAttempt attempt(const std::string& id) const;

    // The files of a finished or cut-short attempt, sorted by path.
    std::vector<StoredFile> files(const std::string& id) const;
    // Checks the index and all files of finished attempts. Returns one line per damaged item; empty if
    // every byte is as stored.
    std::vector<std::string> damage() const;

    // Deletes the rows and folders of all attempts of a trainee from the disk and returns their number.
    // Refused while one of them is being written. Queues the deletion for the centre. If it throws later
    // than that, the next opening completes the deletion.
    std::size_t eraseTrainee(const std::string& trainee);

    // Entries are queued in the same transaction as the change that they report. In order.
    std::vector<OutboxEntry> outbox() const;
    void told(const OutboxEntry&);                             // sent: removes it from the outbox
    void notTold(const OutboxEntry&, const std::string& why);  // failed: stays in the outbox

  private:
    int numberIn(const char* sql) const;
    void needStore() const;
    void open();
    void migrate();
    void sumUpOlder();
    void sumUp(const std::string& id);
    std::vector<std::string> idsWhere(const std::string& condition) const;
    void recover();
    void recoverAttempt(const std::string& id);
    std::size_t doom(const std::string& trainee);
    void removeDoomed();
    void keepReserve() const;
    FileLock makeFolder(const std::string& id) const;
    bool isBeingWritten(const std::string& id) const;
    void settle(const std::string& id);
    void insertEvents(const std::string& id, const std::vector<EventRow>&);
    StoredAttempt readAttempt(const std::string& id) const;
    void execute(const char* sql, const std::vector<std::string>& values) const;
    template <typename Act>
    auto guarded(Act) const;
    void needOpen(const std::string& id) const;

    std::filesystem::path folder_, file_;
    std::unique_ptr<SQLite::Database> database_;
    std::map<std::string, FileLock> open_;  // attempts this store writes
    std::vector<Recovered> recovered_;
    std::vector<std::string> unfinished_;
};

}  // namespace stylet::records
