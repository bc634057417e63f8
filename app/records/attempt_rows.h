// An attempt as the store's rows have it. Inside this folder.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "app/records/store.h"

namespace stylet::records {

// The columns that attemptOf() reads; a condition follows.
inline constexpr const char* kSelectAttempts =
    "SELECT number, id, trainee, started_utc, state, device, patient, patient_digest, scenario, difficulty, "
    "program_version, seed, dt_s, device_gain, registration_rms_m, target_hit, total, ticks FROM attempt ";

// Of the row that `selected` stands on; the attempt's folder lies in `attempts`.
StoredAttempt attemptOf(SQLite::Database&, SQLite::Statement& selected,
                        const std::filesystem::path& attempts);

// Can be a folder's name and names none but its own.
bool isAttemptId(std::string_view);

// Of everything the index says of an attempt.
std::uint32_t rowsSum(const StoredAttempt&);

// SQLite knows no NaN.
void bindNumber(SQLite::Statement&, int place, double value);

}  // namespace stylet::records
