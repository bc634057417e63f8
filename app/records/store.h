// The store: every attempt of a training place, on its own disk first. One SQLite file as index and a folder
// for each attempt:
//   store.sqlite          attempts, metrics, events (WAL); the guide's records.md has the schema
//   attempts/ID/          what `stylet run --out` leaves: summary.json, pictures, record/
// What finish() has acknowledged survives a kill and a power loss. An attempt whose writer is gone is found
// when the store is opened: its files are cut at the last whole frame, it is called cut short, and that is
// said.
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

// What an attempt was made with. `trainee` is a pseudonym (checkTrainee); the store keeps no names.
struct AttemptInfo {
    std::string trainee, device, patient, scenario, difficulty, program_version;
    std::uint64_t patient_digest = 0, seed = 0;
    double dt_s = 0.001, device_gain = 1.0;
    std::optional<double> registration_rms_m{};  // of a device that was registered in the headset's room
};

// In the unit that `unit` names; points of at most `most_points`.
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
    std::optional<AttemptResult> result;  // of one that is done
    std::vector<EventRow> events;         // in the order they were added
    std::filesystem::path folder;
};

// A file of an attempt that was cut short, relative to the attempt's folder.
struct CutFile {
    std::filesystem::path file;
    std::uint64_t ticks = 0;      // in whole frames: kept
    std::uint64_t cut_bytes = 0;  // behind the last of them
    bool headless = false;        // the file ends inside its header: nothing of it can be read
};

struct Recovered {
    std::string id;
    std::vector<CutFile> files;
};
// A file of a finished attempt, relative to its folder.
struct StoredFile {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::uint32_t crc32 = 0;
};

StoredFile sumOf(const std::filesystem::path& folder, const std::filesystem::path& file);
std::vector<StoredFile> sumsOf(const std::filesystem::path& folder);  // of every file in it, by path

// What the training centre is still to be told (outbox.h).
struct OutboxEntry {
    enum class Kind { attempt, erase };
    std::uint64_t number = 0;
    Kind kind = Kind::attempt;
    std::string what;     // an attempt's id, which says nothing of whose it was
    unsigned tries = 0;   // that failed
    std::string error{};  // of the last of them
};

// "attempt ID was cut short: record/inputs.bin keeps 1250 ticks, 312 torn bytes cut off"
std::string describe(const Recovered&);

// Letters, digits, '.', '_' and '-', 1 to 64 of them. Throws patient::DataError with the reason.
void checkTrainee(const std::string& trainee);

// Session thread or a tool; several processes may have one store open. Everything throws patient::DataError
// when the disk refuses, and what it refused is not in the store then.
class Store {
  public:
    // Makes it where there is none, brings an older schema up to date, recovers what was cut short. Refuses
    // what is no store and what a newer program made.
    explicit Store(const std::filesystem::path& folder);
    ~Store();
    Store(Store&&) noexcept;
    Store& operator=(Store&&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    // What opening found cut short, oldest first; known to every later opening as cut short only.
    const std::vector<Recovered>& recovered() const { return recovered_; }
    // A line for each of them, and for what opening could not complete: it is tried again at the next.
    std::vector<std::string> news() const;
    // Folders under attempts/ that the index knows nothing of. They are left alone.
    std::vector<std::filesystem::path> unknownFolders() const;

    // An attempt begins: its id, under which its folder exists then. It is this store's until finish() or the
    // end of the process.
    std::string begin(const AttemptInfo&);
    std::filesystem::path folderOf(const std::string& id) const;
    // Kept through a kill at once, through a power loss with finish().
    void add(const std::string& id, const std::vector<EventRow>&);
    // The same for who cannot wait: false, and nothing is added, while another process writes.
    bool addAtOnce(const std::string& id, const std::vector<EventRow>&);
    // An attempt that never came to a tick: as if it had not begun.
    void abandon(const std::string& id);
    // Acknowledged when it returns: the rows and every file of the folder are on the disk.
    void finish(const std::string& id, const AttemptResult&);

    std::vector<StoredAttempt> attempts(
        const std::string& trainee = "") const;  // oldest first; all when empty
    StoredAttempt attempt(const std::string& id) const;

    // Of an attempt that is finished or was cut short, by path.
    std::vector<StoredFile> files(const std::string& id) const;
    // What is wrong with the index and the files of what is finished, a line each that names the file; empty
    // when every byte is as it was stored.
    std::vector<std::string> damage() const;

    // Rows and folders of all attempts of a trainee, gone from the disk when it returns; how many there were.
    // Refused while one of them is being written. The centre is to be told. Completed at the next opening
    // when it throws later than that.
    std::size_t eraseTrainee(const std::string& trainee);

    // Queued with what it is about, in one transaction; in order.
    std::vector<OutboxEntry> outbox() const;
    void told(const OutboxEntry&);                             // it leaves the outbox
    void notTold(const OutboxEntry&, const std::string& why);  // it stays

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
