#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/Savepoint.h>
#include <SQLiteCpp/VariadicBind.h>
#include <fmt/chrono.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>

#include "app/records/attempt_files.h"
#include "app/records/attempt_rows.h"
#include "app/records/record.h"
#include "app/records/schema.h"
#include "base/hex.h"
#include "patient/package/package.h"

namespace stylet::records {

namespace fs = std::filesystem;

namespace {

constexpr int kBusyTimeout_ms = 10000;           // longest wait for another process that writes
constexpr const char* kReserve = ".reserve";     // deleted to make room when the disk is full
constexpr const char* kSenderLock = ".sending";  // of sendOutbox()
constexpr std::size_t kReserveBytes = 1 << 20;
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

void syncTree(const fs::path& folder) {
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.is_directory())
            syncTree(entry.path());
        else if (entry.is_regular_file())
            syncFile(entry.path());
    }
    syncFolder(folder);
}

// Returns true if the attempt's folder contains no data. The program that created it then ended before it
// stored the attempt's database row, so the id was never used and the folder can be deleted.
bool isEmptyAttemptFolder(const fs::path& folder) {
    if (!fs::is_directory(folder)) return false;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != kLockFile) return false;
    return true;
}

fs::path recordFile(const fs::path& attempt_folder) {
    return attempt_folder / "record" / "record.json";
}

bool isCausedBy(const SQLite::Exception& e, int code) {
    return (e.getErrorCode() & 0xff) == code;  // without the bits of the extended code
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

// Turns any error into a DataError that names the store's file.
template <typename Act>
auto Store::translateErrors(Act act) const {
    try {
        return act();
    } catch (const SQLite::Exception& e) {
        throw DataError(file_, "database", e.what());
    } catch (const fs::filesystem_error& e) {
        throw DataError(e.path1().empty() ? folder_ : e.path1(), "file", e.code().message());
    } catch (const std::logic_error& e) {  // for example from stoull, for a text that is not a number
        throw DataError(file_, "database", std::string("a row cannot be read: ") + e.what());
    }
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

// Runs `act`. If the disk is full, deletes the reserve, runs `act` again and returns true.
template <typename Act>
bool Store::withReserve(const Act& act) {
    try {
        act();
        return false;
    } catch (const SQLite::Exception& e) {
        if (!isCausedBy(e, SQLITE_FULL) || !fs::remove(folder_ / kReserve)) throw;
    }
    act();
    return true;
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
        } catch (const std::exception& e) {
            failed_steps_.push_back("attempt " + id + " has no checksums: " + e.what());
        }
}

// Stores the attempt's checksums and queues it for the centre.
void Store::finalizeAttempt(const std::string& id) {
    storeChecksums(id);
    execute(*database_, "INSERT INTO outbox (kind, what) VALUES ('attempt', ?)", id);
}

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

// Brings the index up to date with a running attempt whose writer has ended. Holds the database's write lock
// throughout. begin() and finish() hold the same lock while they change an attempt's state and its lock file.
void Store::recoverAttempt(const std::string& id) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    if (selectTexts(*database_, "SELECT id FROM attempt WHERE state = 'running' AND id = ?", id).empty() ||
        isBeingWritten(id))
        return;
    recoverLocked(id);
    change.commit();
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
// their folders were copied here, or their rows were removed, and they are marked as imported. A folder
// without a readable record of that id is left alone. A folder that fails does not affect the others. If one
// fails while a lost index is filled again, the next opening continues that.
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
            if (error && isCausedBy(*error, SQLITE_FULL)) throw;  // see withReserve()
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
    execute(*database_, "INSERT INTO log (utc, text) VALUES (?, ?)", utcNow().full, text);
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
    insertRunning(id, attempt.started_utc, attempt.info);
    execute(*database_, "UPDATE attempt SET imported = ? WHERE id = ?", int(imported), id);
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
            "device_gain = ?, registration_rms_m = ? WHERE id = ?",
            info.trainee, attempt.started_utc, std::string(stateName(attempt.state)), info.device,
            info.patient, hexText(info.patient_digest), info.scenario, info.difficulty, info.program_version,
            std::to_string(info.seed), info.dt_s, info.device_gain,
            info.registration_rms_m.value_or(std::nan("")), attempt.id);
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
        const StoredAttempt attempt = loadOwnRecord(id);
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

std::size_t Store::eraseTrainee(const std::string& trainee) {
    return translateErrors([&] {
        std::size_t count = 0;
        withReserve([&] { count = markForDeletion(trainee); });  // deleting also needs some free space
        deleteMarked();
        ensureReserve();
        return count;
    });
}

// Marks the folder for deletion and queues the deletion for the centre. The caller deletes the row.
void Store::doom(const std::string& id) {
    if (isBeingWritten(id)) throw DataError(attemptFolder(id), "attempt", "is being written");
    execute(*database_, "INSERT INTO doomed (folder) VALUES (?)", id);
    execute(*database_, "DELETE FROM outbox WHERE kind = 'attempt' AND what = ?", id);
    // Ask the centre to erase the attempt, even if it is not recorded as sent. It may be in transmission
    // right now.
    execute(*database_, "INSERT INTO outbox (kind, what) VALUES ('erase', ?)", id);
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
    doom(id);
    execute(*database_, "DELETE FROM attempt WHERE id = ?", id);
    execute(*database_, "INSERT INTO log (utc, text) VALUES (?, ?)", utcNow().full,
            fmt::format("discarded attempt {}: {}, scenario {}, {} ticks", id, stateText(attempt),
                        attempt.info.scenario, attempt.result ? attempt.result->ticks : 0));
    change.commit();
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
        doom(id);
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
