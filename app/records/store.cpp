#include "app/records/store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
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

constexpr int kPatience_ms = 10000;  // to wait for another process that writes
constexpr int kShortPatience_ms = 50;
constexpr const char* kReserve = ".reserve";  // deleted to make room when the disk is full
constexpr std::size_t kReserveBytes = 1 << 20;
constexpr std::size_t kMostTrainee = 64;

struct Now {
    std::string compact, full;
};

Now utcNow() {
    const auto now = std::chrono::system_clock::now();
    const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
    const auto ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
    const std::tm utc = *std::gmtime(&seconds);
    std::array<char, 64> compact{}, full{}, tail{};
    std::strftime(compact.data(), compact.size(), "%Y%m%dT%H%M%SZ", &utc);
    std::strftime(full.data(), full.size(), "%Y-%m-%dT%H:%M:%S", &utc);
    std::snprintf(tail.data(), tail.size(), ".%03dZ", int(ms));
    return {compact.data(), std::string(full.data()) + tail.data()};
}

// Ids sort by time. The random tail separates attempts begun in the same second, here or at another site.
std::string newId(const std::string& compact) {
    std::random_device random;
    std::array<char, 16> tail{};
    std::snprintf(tail.data(), tail.size(), "-%08x", unsigned(random()));
    return compact + tail.data();
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
bool neverBegun(const fs::path& folder) {
    if (!fs::is_directory(folder)) return false;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != kWriting) return false;
    return true;
}

// Scope in which database writes do not wait for the disk. They survive a crash of the program. They survive
// a loss of power only after a later write that does wait.
class NoWaiting {
  public:
    explicit NoWaiting(SQLite::Database& database) : database_(database) {
        database_.exec("PRAGMA synchronous = NORMAL");
    }
    ~NoWaiting() { database_.tryExec("PRAGMA synchronous = FULL"); }
    NoWaiting(const NoWaiting&) = delete;
    NoWaiting& operator=(const NoWaiting&) = delete;

  private:
    SQLite::Database& database_;
};

// Scope in which a database write waits for locks of other processes for at most kShortPatience_ms, not
// kPatience_ms.
class Hurry {
  public:
    explicit Hurry(SQLite::Database& database) : database_(database) {
        database_.setBusyTimeout(kShortPatience_ms);
    }
    ~Hurry() { sqlite3_busy_timeout(database_.getHandle(), kPatience_ms); }
    Hurry(const Hurry&) = delete;
    Hurry& operator=(const Hurry&) = delete;

  private:
    SQLite::Database& database_;
};

}  // namespace

void checkTrainee(const std::string& trainee) {
    const auto refuse = [&](const std::string& reason) { throw DataError(trainee, "trainee", reason); };
    if (trainee.empty()) refuse("is empty: a pseudonym is needed");
    if (trainee.size() > kMostTrainee) refuse("is longer than 64 letters");
    const auto fits = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
               c == '_' || c == '-';
    };
    if (!std::all_of(trainee.begin(), trainee.end(), fits))
        refuse("is a pseudonym of letters, digits, '.', '_' and '-', not a name");
}

// Turns any error into a DataError that names the store's file.
template <typename Act>
auto Store::guarded(Act act) const {
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
    guarded([&] {
        fs::create_directories(folder_ / "attempts");
        // Even reading writes files beside the database, and SQLite's error would not name the cause.
        checkWritable(folder_);
        try {
            open();
        } catch (const SQLite::Exception& e) {
            // Even reading needs some free space: delete the reserve and try again.
            if ((e.getErrorCode() & 0xff) != SQLITE_FULL || !fs::remove(folder_ / kReserve)) throw;
            open();
            return;
        }
        keepReserve();
    });
    // If recovery fails, for example on a full disk, reading and deleting still work.
    const auto attempted = [&](const char* what, const auto& act) {
        try {
            guarded(act);
        } catch (const std::exception& e) {
            unfinished_.push_back(std::string(what) +
                                  ", and is tried again at the next opening: " + e.what());
        }
    };
    attempted("a deletion is not complete", [&] { removeDoomed(); });
    attempted("the search for interrupted attempts did not finish", [&] { recover(); });
}

void Store::open() {
    database_ = std::make_unique<SQLite::Database>(
        file_.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kPatience_ms);
    {
        const SQLite::Transaction same_instant(*database_);
        needStore();  // check before anything is changed
    }
    database_->exec("PRAGMA journal_mode = WAL");
    database_->exec("PRAGMA synchronous = FULL");
    database_->exec("PRAGMA foreign_keys = ON");
    database_->exec("PRAGMA secure_delete = ON");
    migrate();
}

Store::~Store() = default;
Store::Store(Store&&) noexcept = default;

std::vector<std::string> Store::news() const {
    std::vector<std::string> lines;
    for (const Recovered& cut : recovered_)
        lines.push_back(describe(cut));
    lines.insert(lines.end(), unfinished_.begin(), unfinished_.end());
    return lines;
}

int Store::numberIn(const char* sql) const {
    return database_->execAndGet(sql).getInt();
}

void Store::needStore() const {
    const int made_by = numberIn("PRAGMA application_id");
    if (made_by != kStoreId && (made_by != 0 || numberIn("SELECT count(*) FROM sqlite_schema") > 0))
        throw DataError(file_, "application_id", "this is not a Stylet store");
}

void Store::migrate() {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    needStore();
    const int version = numberIn("PRAGMA user_version"), newest = int(schemaSteps().size());
    if (version < 0) throw DataError(file_, "user_version", "is below 0");
    if (version > newest)
        throw DataError(file_, "user_version",
                        std::to_string(version) + " is newer than this program's " + std::to_string(newest));
    if (version == newest) return;
    for (const char* step : schemaSteps().subspan(std::size_t(version)))
        database_->exec(step);
    sumUpOlder();
    database_->exec("PRAGMA application_id = " + std::to_string(kStoreId));
    database_->exec("PRAGMA user_version = " + std::to_string(newest));
    change.commit();
    syncFolder(folder_);
    syncFolder(folder_.parent_path());
}

fs::path Store::folderOf(const std::string& id) const {
    if (!isAttemptId(id)) throw DataError(file_, "id", "\"" + id + "\" is not an attempt id");
    return folder_ / "attempts" / id;
}

bool Store::isBeingWritten(const std::string& id) const {
    const fs::path lock = folderOf(id) / kWriting;
    return open_.contains(id) || (fs::exists(lock) && !FileLock::tryTake(lock));
}

void Store::execute(const char* sql, const std::vector<std::string>& values) const {
    SQLite::Statement statement(*database_, sql);
    for (std::size_t i = 0; i < values.size(); ++i)
        statement.bind(int(i) + 1, values[i]);
    statement.exec();
}

// Stores the checksums of an attempt that is finished or cut short. Such an attempt does not change any
// more.
void Store::sumUp(const std::string& id) {
    const std::uint32_t rows = rowsSum(readAttempt(id));
    const auto files = fs::exists(folderOf(id)) ? sumsOf(folderOf(id)) : std::vector<StoredFile>();
    SQLite::Statement row(*database_,
                          "INSERT INTO file (attempt, path, bytes, crc32) SELECT number, ?, ?, ? FROM "
                          "attempt WHERE id = ?");
    for (const StoredFile& file : files) {
        row.bind(1, file.file.generic_string());
        row.bind(2, std::int64_t(file.bytes));
        row.bind(3, std::int64_t(file.crc32));
        row.bind(4, id);
        row.exec();
        row.reset();
    }
    execute("UPDATE attempt SET crc32 = ? WHERE id = ?", {std::to_string(rows), id});
}

// Adds the file checksums of attempts that were stored with schema 1, which had no checksums. The centre uses
// the checksums as the list of an attempt's files.
void Store::sumUpOlder() {
    for (const std::string& id : idsWhere("state <> 'running' AND crc32 IS NULL"))
        try {
            sumUp(id);
        } catch (const std::exception& e) {
            unfinished_.push_back("attempt " + id + " has no checksums: " + e.what());
        }
}

// Stores the attempt's checksums and queues it for the centre.
void Store::settle(const std::string& id) {
    sumUp(id);
    execute("INSERT INTO outbox (kind, what) VALUES ('attempt', ?)", {id});
}

std::vector<std::string> Store::idsWhere(const std::string& condition) const {
    std::vector<std::string> ids;
    SQLite::Statement row(*database_, "SELECT id FROM attempt WHERE " + condition + " ORDER BY number");
    while (row.executeStep())
        ids.push_back(row.getColumn(0).getString());
    return ids;
}

void Store::recover() {
    for (const std::string& id : idsWhere("state = 'running'"))
        try {
            guarded([&] { recoverAttempt(id); });
        } catch (const std::exception& e) {
            unfinished_.push_back("attempt " + id + " was cut short and cannot be recovered: " + e.what());
        }
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    for (const fs::path& folder : unknownFolders())
        if (neverBegun(folder)) fs::remove_all(folder);
    change.commit();
}

// Marks a running attempt as cut short if its writer has ended. Holds the database's write lock throughout.
// begin() and finish() hold the same lock while they change an attempt's state and its lock file.
void Store::recoverAttempt(const std::string& id) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement running(*database_, "SELECT 1 FROM attempt WHERE state = 'running' AND id = ?");
    running.bind(1, id);
    if (!running.executeStep() || isBeingWritten(id)) return;
    running.reset();
    Recovered found{id, cutTails(folderOf(id))};
    fs::remove(folderOf(id) / kWriting);
    if (fs::exists(folderOf(id))) syncTree(folderOf(id));
    execute("UPDATE attempt SET state = 'cut_short' WHERE id = ?", {id});
    settle(id);
    change.commit();
    recovered_.push_back(std::move(found));
}

std::vector<fs::path> Store::unknownFolders() const {
    return guarded([&] {
        std::vector<fs::path> unknown;
        for (const auto& entry : fs::directory_iterator(folder_ / "attempts")) {
            SQLite::Statement known(*database_, "SELECT 1 FROM attempt WHERE id = ?");
            known.bind(1, entry.path().filename().string());
            if (!known.executeStep()) unknown.push_back(entry.path());
        }
        std::sort(unknown.begin(), unknown.end());
        return unknown;
    });
}

FileLock Store::makeFolder(const std::string& id) const {
    fs::create_directory(folderOf(id));
    auto lock = FileLock::tryTake(folderOf(id) / kWriting);
    if (!lock) throw DataError(folderOf(id), "lock", "held by another process");
    syncFolder(folderOf(id));
    syncFolder(folder_ / "attempts");
    return std::move(*lock);
}

std::string Store::begin(const AttemptInfo& info) {
    checkTrainee(info.trainee);
    return guarded([&] {
        const Now now = utcNow();
        const std::string id = newId(now.compact);
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        SQLite::Statement row(*database_,
                              "INSERT INTO attempt (id, trainee, started_utc, state, device, patient, "
                              "patient_digest, scenario, "
                              "difficulty, program_version, seed, dt_s, device_gain, registration_rms_m) "
                              "VALUES (?, ?, ?, 'running', ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
        int place = 0;
        for (const std::string& text :
             {id, info.trainee, now.full, info.device, info.patient, hexText(info.patient_digest),
              info.scenario, info.difficulty, info.program_version, std::to_string(info.seed)})
            row.bind(++place, text);
        row.bind(++place, info.dt_s);
        row.bind(++place, info.device_gain);
        if (info.registration_rms_m) row.bind(++place, *info.registration_rms_m);
        row.exec();
        FileLock lock = makeFolder(id);
        try {
            change.commit();
        } catch (...) {
            std::error_code ignored;
            fs::remove_all(folderOf(id), ignored);
            throw;
        }
        open_.emplace(id, std::move(lock));
        return id;
    });
}

void Store::needOpen(const std::string& id) const {
    if (!open_.contains(id)) throw DataError(folderOf(id), "attempt", "is not being written here");
}

void Store::add(const std::string& id, const std::vector<EventRow>& events) {
    needOpen(id);
    guarded([&] { insertEvents(id, events); });
}

void Store::insertEvents(const std::string& id, const std::vector<EventRow>& events) {
    if (events.empty()) return;
    const NoWaiting into_the_file(*database_);  // finish() syncs to the disk
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement row(
        *database_,
        "INSERT INTO event (attempt, place, tick, kind, text) SELECT number, "
        "(SELECT count(*) FROM event WHERE attempt = number), ?, ?, ? FROM attempt WHERE id = ?");
    for (const EventRow& event : events) {
        row.bind(1, std::int64_t(event.tick));
        row.bind(2, event.kind);
        row.bind(3, event.text);
        row.bind(4, id);
        row.exec();
        row.reset();
    }
    change.commit();
}

bool Store::addAtOnce(const std::string& id, const std::vector<EventRow>& events) {
    needOpen(id);
    return guarded([&] {
        const Hurry hurry(*database_);
        try {
            insertEvents(id, events);
            return true;
        } catch (const SQLite::Exception& e) {
            if ((e.getErrorCode() & 0xff) == SQLITE_BUSY) return false;
            throw;
        }
    });
}

void Store::abandon(const std::string& id) {
    needOpen(id);
    guarded([&] {
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        execute("DELETE FROM attempt WHERE id = ?", {id});
        execute("INSERT INTO doomed (folder) VALUES (?)", {id});
        change.commit();
        open_.erase(id);
        fs::remove_all(folderOf(id));
        syncFolder(folder_ / "attempts");
        execute("DELETE FROM doomed WHERE folder = ?", {id});
    });
}

void Store::finish(const std::string& id, const AttemptResult& result) {
    needOpen(id);
    guarded([&] {
        syncTree(folderOf(id));
        SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
        SQLite::Statement row(
            *database_,
            "UPDATE attempt SET state = 'done', target_hit = ?, total = ?, ticks = ? WHERE id = ?");
        row.bind(1, int(result.target_hit));
        bindNumber(row, 2, result.total);
        row.bind(3, std::int64_t(result.ticks));
        row.bind(4, id);
        row.exec();
        SQLite::Statement metric(*database_,
                                 "INSERT INTO metric (attempt, place, id, name, unit, value, points, "
                                 "most_points) SELECT number, ?, ?, "
                                 "?, ?, ?, ?, ? FROM attempt WHERE id = ?");
        for (std::size_t i = 0; i < result.metrics.size(); ++i) {
            const MetricRow& m = result.metrics[i];
            metric.bind(1, std::int64_t(i));
            metric.bind(2, m.id);
            metric.bind(3, m.name);
            metric.bind(4, m.unit);
            bindNumber(metric, 5, m.value);
            bindNumber(metric, 6, m.points);
            bindNumber(metric, 7, m.most_points);
            metric.bind(8, id);
            metric.exec();
            metric.reset();
        }
        settle(id);
        change.commit();
        fs::remove(folderOf(id) / kWriting);
        open_.erase(id);
    });
}

std::vector<StoredAttempt> Store::attempts(const std::string& trainee) const {
    return guarded([&] {
        SQLite::Transaction same_instant(*database_);
        SQLite::Statement row(
            *database_,
            std::string(kSelectAttempts) + (trainee.empty() ? "" : "WHERE trainee = ? ") + "ORDER BY number");
        if (!trainee.empty()) row.bind(1, trainee);
        std::vector<StoredAttempt> found;
        while (row.executeStep())
            found.push_back(attemptOf(*database_, row, folder_ / "attempts"));
        return found;
    });
}

StoredAttempt Store::attempt(const std::string& id) const {
    return guarded([&] {
        SQLite::Transaction same_instant(*database_);
        return readAttempt(id);
    });
}

StoredAttempt Store::readAttempt(const std::string& id) const {
    SQLite::Statement row(*database_, std::string(kSelectAttempts) + "WHERE id = ?");
    row.bind(1, id);
    if (!row.executeStep()) throw DataError(file_, "attempt " + id, "there is none");
    return attemptOf(*database_, row, folder_ / "attempts");
}

std::vector<StoredFile> Store::files(const std::string& id) const {
    return guarded([&] {
        SQLite::Statement row(
            *database_,
            "SELECT path, bytes, file.crc32 FROM file JOIN attempt ON number = attempt WHERE id = ? "
            "ORDER BY path");
        row.bind(1, id);
        std::vector<StoredFile> found;
        while (row.executeStep())
            found.push_back({row.getColumn(0).getString(), std::uint64_t(row.getColumn(1).getInt64()),
                             std::uint32_t(row.getColumn(2).getInt64())});
        return found;
    });
}

std::vector<std::string> Store::damage() const {
    return guarded([&] {
        std::vector<std::string> found;
        SQLite::Statement check(*database_, "PRAGMA integrity_check");
        while (check.executeStep())
            if (const std::string said = check.getColumn(0).getString(); said != "ok")
                found.push_back(file_.string() + ": " + said);
        SQLite::Statement row(*database_,
                              "SELECT id, crc32 FROM attempt WHERE state <> 'running' ORDER BY number");
        while (row.executeStep()) {
            const std::string id = row.getColumn(0).getString();
            for (const StoredFile& stored : files(id))
                if (std::string line = damageOf(folderOf(id), stored); !line.empty())
                    found.push_back(std::move(line));
            try {
                // NULL: the checksum could not be computed.
                if (!row.getColumn(1).isNull() && row.getColumn(1).getInt64() != rowsSum(readAttempt(id)))
                    found.push_back(file_.string() + ": the checksum of attempt " + id + " does not match");
            } catch (const std::exception& e) {
                found.push_back(file_.string() + ": attempt " + id + " cannot be read: " + e.what());
            }
        }
        return found;
    });
}

std::vector<OutboxEntry> Store::outbox() const {
    return guarded([&] {
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

void Store::told(const OutboxEntry& entry) {
    guarded([&] {
        const NoWaiting lost_it_is_sent_again(*database_);
        execute("DELETE FROM outbox WHERE number = ?", {std::to_string(entry.number)});
    });
}

void Store::notTold(const OutboxEntry& entry, const std::string& why) {
    guarded([&] {
        const NoWaiting only_a_note(*database_);
        execute("UPDATE outbox SET tries = tries + 1, error = ? WHERE number = ?",
                {why, std::to_string(entry.number)});
    });
}

std::size_t Store::eraseTrainee(const std::string& trainee) {
    checkTrainee(trainee);
    return guarded([&] {
        std::size_t count = 0;
        try {
            count = doom(trainee);
        } catch (const SQLite::Exception& e) {
            // Deleting needs some free space too.
            if ((e.getErrorCode() & 0xff) != SQLITE_FULL || !fs::remove(folder_ / kReserve)) throw;
            count = doom(trainee);
        }
        removeDoomed();
        keepReserve();
        return count;
    });
}

std::size_t Store::doom(const std::string& trainee) {
    SQLite::Transaction change(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement ids(*database_, "SELECT id FROM attempt WHERE trainee = ?");
    ids.bind(1, trainee);
    std::vector<std::string> doomed;
    while (ids.executeStep())
        doomed.push_back(ids.getColumn(0).getString());
    for (const std::string& id : doomed) {
        // A damaged row, whose id names no folder of this store. Only the row is deleted, with the other rows
        // below.
        if (!isAttemptId(id)) continue;
        if (isBeingWritten(id)) throw DataError(folderOf(id), "attempt", "is being written");
        execute("INSERT INTO doomed (folder) VALUES (?)", {id});
        execute("DELETE FROM outbox WHERE kind = 'attempt' AND what = ?", {id});
        // Ask the centre to erase the attempt, even if it is not recorded as sent. It may be in transmission
        // right now.
        execute("INSERT INTO outbox (kind, what) VALUES ('erase', ?)", {id});
    }
    execute("DELETE FROM attempt WHERE trainee = ?", {trainee});
    change.commit();
    return doomed.size();
}

// Best effort: without enough free space the store works without a reserve.
void Store::keepReserve() const {
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

// Completes the deletions that eraseTrainee() began, also after a crash. An entry stays until its folder is
// gone.
void Store::removeDoomed() {
    std::vector<std::string> folders;
    SQLite::Statement doomed(*database_, "SELECT folder FROM doomed");
    while (doomed.executeStep())
        folders.push_back(doomed.getColumn(0).getString());
    doomed.reset();
    if (folders.empty()) return;
    for (const std::string& id : folders)
        if (isAttemptId(id)) fs::remove_all(folderOf(id));
    syncFolder(folder_ / "attempts");
    // Makes sure that neither the database file nor its log still contains deleted data.
    database_->exec("VACUUM");
    if (numberIn("PRAGMA wal_checkpoint(TRUNCATE)") != 0)
        throw DataError(
            file_, "log",
            "another process is reading the store: deleted data is gone from the index, but remains in "
            "its log until the store is opened alone");
    for (const std::string& id : folders)
        execute("DELETE FROM doomed WHERE folder = ?", {id});
}

}  // namespace stylet::records
