// Conversion between an attempt and its rows in the store. Internal to this folder.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "app/records/store.h"

namespace stylet::records {

// The columns that readAttemptRow() reads. Append a condition to it.
inline constexpr const char* kSelectAttempts =
    "SELECT number, id, trainee, started_utc, state, device, patient, patient_digest, scenario, difficulty, "
    "program_version, seed, dt_s, device_gain, registration_rms_m, target_hit, total, ticks, aborted, "
    "score_version, imported FROM attempt ";

// Reads the attempt from the current row of `selected`. `attempts` is the folder that contains its folder.
StoredAttempt readAttemptRow(SQLite::Database&, SQLite::Statement& selected,
                             const std::filesystem::path& attempts);

// Returns true if the text is a valid folder name without path separators or parent references.
bool isAttemptId(std::string_view);

// Checksum over everything that the index stores about an attempt.
std::uint32_t computeRowsChecksum(const StoredAttempt&);

}  // namespace stylet::records
