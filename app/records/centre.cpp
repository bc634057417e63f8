#include "app/records/centre.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <pqxx/pqxx>

#include "app/records/export.h"
#include "patient/package/package.h"

namespace stylet::records {

using Json = nlohmann::ordered_json;

namespace {

// Step i migrates stylet.schema_version from i to i + 1. Never change a step that has been released.
constexpr std::array kCentreSteps{R"sql(
CREATE TABLE stylet.attempt (
    id text PRIMARY KEY,
    trainee text NOT NULL,
    started_utc timestamptz NOT NULL,
    state text NOT NULL CHECK (state IN ('done', 'cut_short')),
    device text NOT NULL,
    patient text NOT NULL,
    patient_digest text NOT NULL,
    scenario text NOT NULL,
    difficulty text NOT NULL,
    program_version text NOT NULL,
    seed numeric(20) NOT NULL,
    dt_s double precision NOT NULL,
    device_gain double precision NOT NULL,
    registration_rms_m double precision,
    target_hit boolean,
    total double precision,
    ticks bigint,
    received timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX attempt_of_trainee ON stylet.attempt (trainee);
CREATE TABLE stylet.metric (
    attempt text NOT NULL REFERENCES stylet.attempt ON DELETE CASCADE,
    place integer NOT NULL,
    id text NOT NULL,
    name text NOT NULL,
    unit text NOT NULL,
    value double precision,
    points double precision,
    most_points double precision,
    PRIMARY KEY (attempt, place)
);
CREATE TABLE stylet.event (
    attempt text NOT NULL REFERENCES stylet.attempt ON DELETE CASCADE,
    place integer NOT NULL,
    tick bigint NOT NULL,
    kind text NOT NULL,
    text text NOT NULL,
    PRIMARY KEY (attempt, place)
);
CREATE TABLE stylet.file (
    attempt text NOT NULL REFERENCES stylet.attempt ON DELETE CASCADE,
    path text NOT NULL,
    bytes bigint NOT NULL,
    crc32 bigint NOT NULL,
    PRIMARY KEY (attempt, path)
);
CREATE TABLE stylet.file_part (
    attempt text NOT NULL,
    path text NOT NULL,
    part integer NOT NULL,
    content bytea NOT NULL,
    PRIMARY KEY (attempt, path, part),
    FOREIGN KEY (attempt, path) REFERENCES stylet.file ON DELETE CASCADE
);
)sql",
                                  R"sql(
ALTER TABLE stylet.attempt ADD COLUMN aborted boolean, ADD COLUMN score_version integer;
)sql",
                                  R"sql(
ALTER TABLE stylet.attempt ADD COLUMN imported boolean NOT NULL DEFAULT false;
)sql"};

constexpr const char* kInsertAttempt = R"sql(
INSERT INTO stylet.attempt (id, trainee, started_utc, state, device, patient, patient_digest, scenario, difficulty,
    program_version, seed, dt_s, device_gain, registration_rms_m, target_hit, total, ticks, aborted,
    score_version, imported)
SELECT * FROM jsonb_to_record($1::jsonb) AS a (id text, trainee text, started_utc timestamptz, state text, device text,
    patient text, patient_digest text, scenario text, difficulty text, program_version text, seed numeric,
    dt_s double precision, device_gain double precision, registration_rms_m double precision, target_hit boolean,
    total double precision, ticks bigint, aborted boolean, score_version integer,
    imported boolean)
ON CONFLICT (id) DO NOTHING
)sql";

constexpr const char* kInsertMetrics = R"sql(
INSERT INTO stylet.metric SELECT $1, m.* FROM jsonb_to_recordset($2::jsonb) AS m (place integer, id text, name text,
    unit text, value double precision, points double precision, most_points double precision)
)sql";

constexpr const char* kInsertEvents = R"sql(
INSERT INTO stylet.event SELECT $1, e.* FROM jsonb_to_recordset($2::jsonb) AS e (place integer, tick bigint, kind text,
    text text)
)sql";

// JSON has neither infinity nor NaN; PostgreSQL reads both by name.
Json postgresNumber(double v) {
    if (std::isnan(v)) return "NaN";
    if (std::isinf(v)) return v > 0 ? "Infinity" : "-Infinity";
    return v;
}

// PostgreSQL texts cannot contain NUL.
std::string postgresText(std::string text) {
    std::erase(text, '\0');
    return text;
}

// Adds to each row its index, as "place".
Json numbered(Json rows) {
    for (std::size_t place = 0; place < rows.size(); ++place)
        rows[place]["place"] = place;
    return rows;
}

std::string jsonText(const Json& j) {
    return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void insertFile(pqxx::work& work, const StoredAttempt& attempt, const StoredFile& file) {
    const std::string path = file.file.generic_string();
    work.exec_params("INSERT INTO stylet.file VALUES ($1, $2, $3, $4)", attempt.id, path, file.bytes,
                     file.crc32);
    int part = 0;
    const auto insertPart = [&](std::span<const char> bytes) {
        work.exec_params("INSERT INTO stylet.file_part VALUES ($1, $2, $3, $4)", attempt.id, path, part++,
                         pqxx::binarystring(bytes.data(), bytes.size()));
    };
    if (computeChecksum(attempt.folder, file.file, insertPart) != file)
        throw DataError(attempt.folder / file.file, "checksum", "the file has changed since it was stored");
}

// Adds timeouts to the connection string: 5 s to connect, 20 s for unacknowledged data.
std::string withTimeouts(const std::string& database) {
    if (database.find("connect_timeout") != std::string::npos) return database;
    if (database.find("://") == std::string::npos)
        return database + " connect_timeout=5 tcp_user_timeout=20000";
    const char joint = database.find('?') == std::string::npos ? '?' : '&';
    return database + joint + "connect_timeout=5&tcp_user_timeout=20000";
}

// The message with libpq's line breaks replaced by spaces.
std::string messageText(const std::exception& e) {
    std::string text = e.what();
    std::replace(text.begin(), text.end(), '\n', ' ');
    text.erase(text.find_last_not_of(' ') + 1);
    return text;
}

// Runs `act`. A lost connection becomes CentreUnreachable; other database errors become std::runtime_error.
template <typename Act>
void withTranslatedErrors(const Act& act) {
    try {
        act();
    } catch (const DataError&) {
        throw;
    } catch (const pqxx::broken_connection& e) {
        throw CentreUnreachable(messageText(e));
    } catch (const pqxx::in_doubt_error& e) {  // safe to retry: sending twice stores it once
        throw CentreUnreachable(messageText(e));
    } catch (const std::exception& e) {
        throw std::runtime_error(messageText(e));
    }
}

}  // namespace

struct Centre::Connection {
    Connection(const std::string& database, std::function<void(int)> on_connected)
        : connected(std::move(on_connected)), to(withTimeouts(database)) {
        if (connected) connected(to.sock());
    }
    ~Connection() {
        if (connected) connected(-1);
    }
    std::function<void(int)> connected;
    pqxx::connection to;
};

Centre::Centre(const std::string& database, std::function<void(int)> connected) {
    withTranslatedErrors([&] {
        connection_ = std::make_unique<Connection>(database, std::move(connected));
        pqxx::work work(connection_->to);
        work.exec("SELECT pg_advisory_xact_lock(1400471916)");  // "Styl": one connection migrates at a time
        work.exec("SET client_min_messages = warning");
        // A user who may only write into existing tables must not need the right to create a schema.
        if (work.exec("SELECT to_regclass('stylet.schema_version')")[0][0].is_null()) {
            work.exec("CREATE SCHEMA IF NOT EXISTS stylet");
            work.exec("CREATE TABLE stylet.schema_version (version integer NOT NULL)");
        }
        const pqxx::result found = work.exec("SELECT version FROM stylet.schema_version");
        const std::size_t version = found.empty() ? 0 : found[0][0].as<std::size_t>();
        if (version > kCentreSteps.size())
            throw std::runtime_error(
                fmt::format("its schema {} is newer than this program's {}: update Stylet", version,
                            kCentreSteps.size()));
        for (std::size_t step = version; step < kCentreSteps.size(); ++step)
            work.exec(kCentreSteps[step]);
        if (found.empty())
            work.exec_params("INSERT INTO stylet.schema_version VALUES ($1)", kCentreSteps.size());
        else if (version < kCentreSteps.size())
            work.exec_params("UPDATE stylet.schema_version SET version = $1", kCentreSteps.size());
        work.commit();
    });
}

Centre::~Centre() = default;

void Centre::insert(const StoredAttempt& attempt, const std::vector<StoredFile>& files) {
    withTranslatedErrors([&] {
        pqxx::work work(connection_->to);
        Json row = attemptJson(attempt, postgresNumber, postgresText);
        const Json metrics = numbered(std::move(row["metrics"])), events = numbered(std::move(row["events"]));
        const auto insertRow = [&] {
            return work.exec_params(kInsertAttempt, jsonText(row)).affected_rows() > 0;
        };
        if (!insertRow()) {
            if (attempt.imported) return;
            // The original replaces a copy that another site imported and sent first.
            work.exec_params("DELETE FROM stylet.attempt WHERE id = $1 AND imported", attempt.id);
            if (!insertRow()) return;
        }
        work.exec_params(kInsertMetrics, attempt.id, jsonText(metrics));
        work.exec_params(kInsertEvents, attempt.id, jsonText(events));
        for (const StoredFile& file : files)
            insertFile(work, attempt, file);
        work.commit();
    });
}

void Centre::erase(const std::string& id) {
    withTranslatedErrors([&] {
        pqxx::work work(connection_->to);
        work.exec_params("DELETE FROM stylet.attempt WHERE id = $1", id);
        work.commit();
    });
}

bool hasCentre() {
    return true;
}

}  // namespace stylet::records
