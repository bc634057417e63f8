#include "app/records/schema.h"

#include <array>

namespace stylet::records {

namespace {

constexpr const char* kVersion1 = R"sql(
CREATE TABLE attempt (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    trainee TEXT NOT NULL,
    started_utc TEXT NOT NULL,
    state TEXT NOT NULL CHECK (state IN ('running', 'done', 'cut_short')),
    device TEXT NOT NULL,
    patient TEXT NOT NULL,
    patient_digest TEXT NOT NULL,
    scenario TEXT NOT NULL,
    difficulty TEXT NOT NULL,
    program_version TEXT NOT NULL,
    seed TEXT NOT NULL,
    dt_s REAL NOT NULL,
    device_gain REAL NOT NULL,
    registration_rms_m REAL,
    target_hit INTEGER,
    total REAL,
    ticks INTEGER
) STRICT;
CREATE INDEX attempt_of_trainee ON attempt (trainee);
CREATE TABLE metric (
    attempt INTEGER NOT NULL REFERENCES attempt (number) ON DELETE CASCADE,
    place INTEGER NOT NULL,
    id TEXT NOT NULL,
    name TEXT NOT NULL,
    unit TEXT NOT NULL,
    value REAL,
    points REAL,
    most_points REAL,
    PRIMARY KEY (attempt, place)
) STRICT, WITHOUT ROWID;
CREATE TABLE event (
    attempt INTEGER NOT NULL REFERENCES attempt (number) ON DELETE CASCADE,
    place INTEGER NOT NULL,
    tick INTEGER NOT NULL,
    kind TEXT NOT NULL,
    text TEXT NOT NULL,
    PRIMARY KEY (attempt, place)
) STRICT, WITHOUT ROWID;
CREATE TABLE doomed (folder TEXT PRIMARY KEY) STRICT;
)sql";

// Adds checksums of finished attempts' rows and files, and the outbox for the training centre.
constexpr const char* kVersion2 = R"sql(
ALTER TABLE attempt ADD COLUMN crc32 INTEGER;
CREATE TABLE file (
    attempt INTEGER NOT NULL REFERENCES attempt (number) ON DELETE CASCADE,
    path TEXT NOT NULL,
    bytes INTEGER NOT NULL,
    crc32 INTEGER NOT NULL,
    PRIMARY KEY (attempt, path)
) STRICT, WITHOUT ROWID;
CREATE TABLE outbox (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    kind TEXT NOT NULL CHECK (kind IN ('attempt', 'erase')),
    what TEXT NOT NULL,
    tries INTEGER NOT NULL DEFAULT 0,
    error TEXT NOT NULL DEFAULT ''
) STRICT;
INSERT INTO outbox (kind, what) SELECT 'attempt', id FROM attempt WHERE state <> 'running' ORDER BY number;
)sql";

// Adds aborted attempts, the version of their score, and the log of discarded attempts.
constexpr const char* kVersion3 = R"sql(
ALTER TABLE attempt ADD COLUMN aborted INTEGER NOT NULL DEFAULT 0;
ALTER TABLE attempt ADD COLUMN score_version INTEGER NOT NULL DEFAULT 1;
CREATE TABLE log (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    utc TEXT NOT NULL,
    text TEXT NOT NULL
) STRICT;
)sql";

// Adds the column `imported` (StoredAttempt::imported).
constexpr const char* kVersion4 = R"sql(
ALTER TABLE attempt ADD COLUMN imported INTEGER NOT NULL DEFAULT 0;
)sql";

// The folder of an imported attempt contains the mark too: the store writes it (Store::markImportedFolders).
constexpr const char* kVersion5 = "";

constexpr std::array kSteps{kVersion1, kVersion2, kVersion3, kVersion4, kVersion5};

}  // namespace

std::span<const char* const> schemaSteps() {
    return kSteps;
}

}  // namespace stylet::records
