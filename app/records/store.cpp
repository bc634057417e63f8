#include "app/records/store.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>

#include "app/records/attempt_files.h"
#include "app/records/attempt_rows.h"
#include "app/records/record.h"
#include "app/records/schema.h"
#include "app/records/sql.h"
#include "base/hex.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr int kBusyTimeout_ms = 10000;           // longest wait for another process that writes
constexpr const char* kSenderLock = ".sending";  // of sendOutbox()
constexpr std::size_t kMaxTraineeLength = 64;

struct Now {
    std::string compact, full;
};

Now utcNow() {
    const auto now = std::chrono::system_clock::now();
    const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
    const auto ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
    const std::tm utc = *std::gmtime(&seconds);
    return {fmt::format("{:%Y%m%dT%H%M%SZ}", utc), fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", utc, ms)};
}

// Ids sort by time. The random tail separates attempts begun in the same second, here or at another site.
std::string newId(const std::string& compact) {
    std::random_device random;
    return fmt::format("{}-{:08x}", compact, unsigned(random()));
}

// Scope in which database writes do not wait for the disk. They survive a crash of the program. They survive
// a loss of power only after a later write that does wait.
class RelaxedSync {
  public:
    explicit RelaxedSync(SQLite::Database& database) : database_(database) {
        database_.exec("PRAGMA synchronous = NORMAL");
    }
    ~RelaxedSync() { database_.tryExec("PRAGMA synchronous = FULL"); }
    RelaxedSync(const RelaxedSync&) = delete;
    RelaxedSync& operator=(const RelaxedSync&) = delete;

  private:
    SQLite::Database& database_;
};

}  // namespace

void checkTrainee(const std::string& trainee) {
    const auto refuse = [&](const std::string& reason) {
        std::string printable = trainee;  // a control character would reach the user's terminal
        std::replace_if(
            printable.begin(), printable.end(),
            [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
        throw DataError(printable, "trainee", reason);
    };
    if (trainee.empty()) refuse("is empty: a pseudonym is needed");
    if (trainee.size() > kMaxTraineeLength) refuse("is longer than 64 letters");
    const auto plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    };
    const auto fits = [&](char c) { return plain(c) || c == '.' || c == '_' || c == '-'; };
    if (!std::all_of(trainee.begin(), trainee.end(), fits))
        refuse("is a pseudonym of letters, digits, '.', '_' and '-', not a name");
    if (!plain(trainee.front()) || !plain(trainee.back()))
        refuse("must begin and end with a letter or digit");
}

Store::Store(const fs::path& folder) : folder_(fs::absolute(folder)), file_(folder_ / "store.sqlite") {
    translateErrors([&] {
        if (!fs::exists(file_) && fs::exists(folder_ / "attempts.csv"))
            throw DataError(folder_, "store",
                            "this is an export, not a Stylet store: pass the folder of the store");
        createPrivateFolders(folder_ / "attempts");
        // Even reading creates files beside the database. If that fails, SQLite's error does not name the
        // cause.
        checkWritable(folder_);
        if (!withReserve([&] { open(); })) ensureReserve();  // even reading needs some free space
    });
    // If recovery fails, for example on a full disk, reading and deleting still work.
    const auto tryStep = [&](const char* what, const auto& act) {
        try {
            translateErrors(act);
        } catch (const std::exception& e) {
            failed_steps_.push_back(std::string(what) +
                                    ", and is tried again at the next opening: " + e.what());
        }
    };
    tryStep("withdrawing the access of other users failed", [&] {
        if (const std::size_t count = makeStorePrivate())
            tightened_ = fmt::format(
                "{} was open to others: withdrew the access of group and others ({} files and folders)",
                folder_.string(), count);
    });
    tryStep("a deletion is not complete", [&] { deleteMarked(); });
    tryStep("the search for interrupted attempts did not finish", [&] { recover(); });
}

// Withdraws the access of group and others from what the store creates. The folder may contain other files.
std::size_t Store::makeStorePrivate() const {
    const fs::path folder = fs::canonical(folder_);
    std::size_t count = std::size_t(makePrivate(folder));
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name == "attempts" && !entry.is_symlink())
            count += makeTreePrivate(entry.path());
        else if (name.starts_with("store.sqlite") || name == kReserve || name == kSenderLock)
            count += std::size_t(makePrivate(entry.path()));
    }
    return count;
}

void Store::open() {
    createPrivateFile(file_);  // SQLite gives its log files the mode of the database
    database_ = std::make_unique<SQLite::Database>(
        file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kBusyTimeout_ms);
    {
        const SQLite::Transaction read_snapshot(*database_);
        checkIsStore();  // check before anything is changed
    }
    database_->exec("PRAGMA journal_mode = WAL");
    database_->exec("PRAGMA synchronous = FULL");
    database_->exec("PRAGMA foreign_keys = ON");
    database_->exec("PRAGMA secure_delete = ON");
    migrate();
}

Store::~Store() = default;
Store::Store(Store&&) noexcept = default;

std::vector<std::string> Store::openingMessages() const {
    std::vector<std::string> lines;
    if (!tightened_.empty()) lines.push_back(tightened_);
    lines.insert(lines.end(), indexed_.begin(), indexed_.end());
    for (const RecoveredAttempt& cut : recovered_)
        lines.push_back(describe(cut));
    lines.insert(lines.end(), failed_steps_.begin(), failed_steps_.end());
    return lines;
}

int Store::queryInt(const char* sql) const {
    return database_->execAndGet(sql).getInt();
}

void Store::checkIsStore() const {
    const int made_by = queryInt("PRAGMA application_id");
    if (made_by != kStoreId && (made_by != 0 || queryInt("SELECT count(*) FROM sqlite_schema") > 0))
        throw DataError(file_, "application_id", "this is not a Stylet store");
}

void Store::migrate() {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    checkIsStore();
    const int version = queryInt("PRAGMA user_version"), newest = int(schemaSteps().size());
    if (version < 0) throw DataError(file_, "user_version", "is below 0");
    if (version > newest)
        throw DataError(file_, "user_version",
                        std::to_string(version) + " is newer than this program's " + std::to_string(newest));
    if (version == newest) return;
    for (const char* step : schemaSteps().subspan(std::size_t(version)))
        database_->exec(step);
    storeMissingChecksums();
    if (version < 5) markImportedFolders();
    database_->exec("PRAGMA application_id = " + std::to_string(kStoreId));
    database_->exec("PRAGMA user_version = " + std::to_string(newest));
    change.commit();
    syncFolder(folder_);
    syncFolder(folder_.parent_path());
}

fs::path Store::attemptFolder(const std::string& id) const {
    if (!isAttemptId(id)) throw DataError(file_, "id", "\"" + id + "\" is not an attempt id");
    return folder_ / "attempts" / id;
}

bool Store::isBeingWritten(const std::string& id) const {
    const fs::path lock = attemptFolder(id) / kLockFile;
    return open_.contains(id) || (fs::exists(lock) && !FileLock::tryLock(lock));
}

// Stores the checksums of an attempt that is finished or cut short. Such an attempt does not change any more.
void Store::storeChecksums(const std::string& id) {
    const std::uint32_t rows = computeRowsChecksum(readAttempt(id));
    const auto files =
        fs::exists(attemptFolder(id)) ? computeChecksums(attemptFolder(id)) : std::vector<StoredFile>();
    execute(*database_, "DELETE FROM file WHERE attempt = (SELECT number FROM attempt WHERE id = ?)", id);
    SQLite::Statement row(
        *database_,
        "INSERT INTO file (attempt, path, bytes, crc32) SELECT number, ?, ?, ? FROM attempt WHERE id = ?");
    for (const StoredFile& file : files)
        run(row, file.file.generic_string(), std::int64_t(file.bytes), file.crc32, id);
    execute(*database_, "UPDATE attempt SET crc32 = ? WHERE id = ?", rows, id);
}

// Adds the file checksums of attempts that were stored with schema 1, which had no checksums. The centre uses
// the checksums as the list of an attempt's files.
void Store::storeMissingChecksums() {
    for (const std::string& id : selectTexts(
             *database_, "SELECT id FROM attempt WHERE state <> 'running' AND crc32 IS NULL ORDER BY number"))
        try {
            storeChecksums(id);
        } catch (const SQLite::Exception&) {
            throw;  // SQLite may have rolled back the steps before
        } catch (const std::exception& e) {
            failed_steps_.push_back("attempt " + id + " has no checksums: " + e.what());
        }
}

// Schema 4 stored the mark of an imported attempt in its row only.
void Store::markImportedFolders() {
    for (const std::string& id : selectTexts(*database_, "SELECT id FROM attempt WHERE imported = 1"))
        try {
            markImported(attemptFolder(id));
            const StoredFile mark = computeChecksum(attemptFolder(id), kImportedMark);
            execute(*database_,
                    "INSERT OR REPLACE INTO file (attempt, path, bytes, crc32) SELECT number, ?, ?, ? FROM "
                    "attempt WHERE id = ?",
                    mark.file.string(), std::int64_t(mark.bytes), mark.crc32, id);
        } catch (const SQLite::Exception&) {
            throw;
        } catch (const std::exception& e) {
            failed_steps_.push_back("attempt " + id + " cannot be marked as imported: " + e.what());
        }
}

// Stores the attempt's checksums and queues it for the centre.
void Store::finalizeAttempt(const std::string& id) {
    storeChecksums(id);
    execute(*database_, "INSERT INTO outbox (kind, what) VALUES ('attempt', ?)", id);
}

FileLock Store::makeFolder(const std::string& id) const {
    createPrivateFolders(attemptFolder(id));
    auto lock = FileLock::tryLock(attemptFolder(id) / kLockFile);
    if (!lock) throw DataError(attemptFolder(id), "lock", "held by another process");
    syncFolder(attemptFolder(id));
    syncFolder(folder_ / "attempts");
    return std::move(*lock);
}

void Store::insertRunning(const std::string& id, const std::string& started_utc, const AttemptInfo& info) {
    execute(*database_,
            "INSERT INTO attempt (id, trainee, started_utc, state, device, patient, patient_digest, "
            "scenario, difficulty, program_version, seed, dt_s, device_gain, registration_rms_m) "
            "VALUES (?, ?, ?, 'running', ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            id, info.trainee, started_utc, info.device, info.patient, hexText(info.patient_digest),
            info.scenario, info.difficulty, info.program_version, std::to_string(info.seed), info.dt_s,
            info.device_gain, info.registration_rms_m.value_or(std::nan("")));
}

// Replaces the rows of an attempt by the facts of its record. Its files' checksums follow separately.
void Store::indexRecord(const StoredAttempt& attempt) {
    const AttemptInfo& info = attempt.info;
    execute(*database_,
            "UPDATE attempt SET trainee = ?, started_utc = ?, state = ?, device = ?, patient = ?, "
            "patient_digest = ?, scenario = ?, difficulty = ?, program_version = ?, seed = ?, dt_s = ?, "
            "device_gain = ?, registration_rms_m = ?, imported = ? WHERE id = ?",
            info.trainee, attempt.started_utc, std::string(stateName(attempt.state)), info.device,
            info.patient, hexText(info.patient_digest), info.scenario, info.difficulty, info.program_version,
            std::to_string(info.seed), info.dt_s, info.device_gain,
            info.registration_rms_m.value_or(std::nan("")), int(attempt.imported), attempt.id);
    execute(*database_, "DELETE FROM event WHERE attempt = (SELECT number FROM attempt WHERE id = ?)",
            attempt.id);
    execute(*database_, "DELETE FROM metric WHERE attempt = (SELECT number FROM attempt WHERE id = ?)",
            attempt.id);
    std::int64_t place = 0;
    SQLite::Statement event(*database_,
                            "INSERT INTO event (attempt, place, tick, kind, text) SELECT number, ?, ?, ?, ? "
                            "FROM attempt WHERE id = ?");
    for (const EventRow& e : attempt.events)
        run(event, place++, std::int64_t(e.tick), e.kind, e.text, attempt.id);
    if (!attempt.result) return;
    execute(*database_,
            "UPDATE attempt SET target_hit = ?, total = ?, ticks = ?, aborted = ?, score_version = ? WHERE "
            "id = ?",
            int(attempt.result->target_hit), attempt.result->total, std::int64_t(attempt.result->ticks),
            int(attempt.result->aborted), std::int64_t(attempt.result->score_version), attempt.id);
    place = 0;
    SQLite::Statement metric(*database_,
                             "INSERT INTO metric (attempt, place, id, name, unit, value, points, "
                             "most_points) SELECT number, ?, ?, ?, ?, ?, ?, ? FROM attempt WHERE id = ?");
    for (const MetricRow& m : attempt.result->metrics)
        run(metric, place++, m.id, m.name, m.unit, m.value, m.points, m.max_points, attempt.id);
}

StoredAttempt Store::loadOwnRecord(const std::string& id) const {
    const fs::path folder = attemptFolder(id);
    StoredAttempt attempt = makeStoredAttempt(loadAttemptHead(folder), folder);
    if (attempt.id != id) throw DataError(recordFile(folder), "id", "\"" + attempt.id + "\" is not " + id);
    try {
        checkTrainee(attempt.info.trainee);
    } catch (const DataError& e) {
        throw DataError(recordFile(folder), "trainee", e.what());
    }
    return attempt;
}

std::string Store::begin(const AttemptInfo& info) {
    checkTrainee(info.trainee);
    return translateErrors([&] {
        const Now now = utcNow();
        const std::string id = newId(now.compact);
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        insertRunning(id, now.full, info);
        FileLock lock = makeFolder(id);
        try {
            change.commit();
        } catch (...) {
            std::error_code ignored;
            fs::remove_all(attemptFolder(id), ignored);
            throw;
        }
        open_.emplace(id, std::move(lock));
        return id;
    });
}

void Store::checkOpen(const std::string& id) const {
    if (!open_.contains(id)) throw DataError(attemptFolder(id), "attempt", "is not being written here");
}

void Store::abandon(const std::string& id) {
    checkOpen(id);
    translateErrors([&] {
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        execute(*database_, "DELETE FROM attempt WHERE id = ?", id);
        execute(*database_, "INSERT INTO doomed (folder) VALUES (?)", id);
        change.commit();
        open_.erase(id);
        fs::remove_all(attemptFolder(id));
        syncFolder(folder_ / "attempts");
        execute(*database_, "DELETE FROM doomed WHERE folder = ?", id);
    });
}

void Store::finish(const std::string& id) {
    checkOpen(id);
    translateErrors([&] {
        const fs::path folder = attemptFolder(id);
        StoredAttempt attempt = loadOwnRecord(id);
        attempt.imported = false;  // whatever lies in its folder: this process has recorded it
        if (!attempt.result)
            throw DataError(recordFile(folder), "result", "is missing: the attempt has not ended");
        makeTreePrivate(folder);  // also what other writers put there
        syncTree(folder);
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        indexRecord(attempt);
        finalizeAttempt(id);
        change.commit();
        fs::remove(folder / kLockFile);
        open_.erase(id);
    });
}

std::vector<StoredAttempt> Store::attempts(const std::string& trainee) const {
    return translateErrors([&] {
        SQLite::Transaction read_snapshot(*database_);
        SQLite::Statement row(
            *database_,
            std::string(kSelectAttempts) + (trainee.empty() ? "" : "WHERE trainee = ? ") + "ORDER BY number");
        if (!trainee.empty()) row.bind(1, trainee);
        std::vector<StoredAttempt> found;
        while (row.executeStep())
            found.push_back(readAttemptRow(*database_, row, folder_ / "attempts"));
        return found;
    });
}

StoredAttempt Store::attempt(const std::string& id) const {
    return translateErrors([&] {
        SQLite::Transaction read_snapshot(*database_);
        return readAttempt(id);
    });
}

StoredAttempt Store::readAttempt(const std::string& id) const {
    SQLite::Statement row(*database_, std::string(kSelectAttempts) + "WHERE id = ?");
    row.bind(1, id);
    if (!row.executeStep()) throw DataError(file_, "attempt " + id, "there is none");
    return readAttemptRow(*database_, row, folder_ / "attempts");
}

std::vector<StoredFile> Store::files(const std::string& id) const {
    return translateErrors([&] {
        SQLite::Statement row(*database_,
                              "SELECT path, bytes, file.crc32 FROM file JOIN attempt ON number = attempt "
                              "WHERE id = ? ORDER BY path");
        row.bind(1, id);
        std::vector<StoredFile> found;
        while (row.executeStep())
            found.push_back({row.getColumn(0).getString(), std::uint64_t(row.getColumn(1).getInt64()),
                             std::uint32_t(row.getColumn(2).getInt64())});
        return found;
    });
}

void Store::checkRecord(const std::string& id) const {
    for (const StoredFile& stored : files(id))
        if (stored.file == fs::path("record") / "record.json")
            if (const std::string damage = findDamage(attemptFolder(id), stored); !damage.empty())
                throw DataError(file_, "attempt " + id, damage);
}

std::vector<std::string> Store::damage() const {
    return translateErrors([&] {
        std::vector<std::string> found;
        for (const std::string& line : selectTexts(*database_, "PRAGMA integrity_check"))
            if (line != "ok") found.push_back(file_.string() + ": " + line);
        SQLite::Statement row(
            *database_, "SELECT id, crc32, state FROM attempt WHERE state <> 'running' ORDER BY number");
        while (row.executeStep()) {
            const std::string id = row.getColumn(0).getString();
            const std::size_t count = found.size();
            for (const StoredFile& stored : files(id))
                if (std::string line = findDamage(attemptFolder(id), stored); !line.empty())
                    found.push_back(std::move(line));
            try {
                // A NULL column means that the checksum could not be computed.
                if (!row.getColumn(1).isNull() &&
                    row.getColumn(1).getInt64() != computeRowsChecksum(readAttempt(id)))
                    found.push_back(file_.string() + ": the checksum of attempt " + id + " does not match");
                // A finished attempt may have been damaged before the checksums were computed, if its index
                // was lost.
                if (found.size() == count && row.getColumn(2).getString() == stateName(AttemptState::done))
                    for (const std::string& file : findTornFiles(attemptFolder(id)))
                        found.push_back((attemptFolder(id) / file).string());
            } catch (const std::exception& e) {
                found.push_back(file_.string() + ": attempt " + id + " cannot be read: " + e.what());
            }
        }
        return found;
    });
}

std::vector<OutboxEntry> Store::outbox() const {
    return translateErrors([&] {
        SQLite::Statement row(*database_,
                              "SELECT number, kind, what, tries, error FROM outbox ORDER BY number");
        std::vector<OutboxEntry> entries;
        while (row.executeStep())
            entries.push_back({std::uint64_t(row.getColumn(0).getInt64()),
                               row.getColumn(1).getString() == "erase" ? OutboxEntry::Kind::erase
                                                                       : OutboxEntry::Kind::attempt,
                               row.getColumn(2).getString(), row.getColumn(3).getUInt(),
                               row.getColumn(4).getString()});
        return entries;
    });
}

void Store::markSent(const OutboxEntry& entry) {
    translateErrors([&] {
        const RelaxedSync relaxed_sync(*database_);
        execute(*database_, "DELETE FROM outbox WHERE number = ?", std::int64_t(entry.number));
    });
}

void Store::markFailed(const OutboxEntry& entry, const std::string& why) {
    translateErrors([&] {
        const RelaxedSync relaxed_sync(*database_);
        execute(*database_, "UPDATE outbox SET tries = tries + 1, error = ? WHERE number = ?", why,
                std::int64_t(entry.number));
    });
}

void Store::addToLog(const std::string& text) {
    execute(*database_, "INSERT INTO log (utc, text) VALUES (?, ?)", utcNow().full, text);
}

std::vector<LogEntry> Store::log() const {
    return translateErrors([&] {
        SQLite::Statement row(*database_, "SELECT utc, text FROM log ORDER BY number");
        std::vector<LogEntry> entries;
        while (row.executeStep())
            entries.push_back({row.getColumn(0).getString(), row.getColumn(1).getString()});
        return entries;
    });
}

}  // namespace stylet::records
