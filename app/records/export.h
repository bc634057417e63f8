// The only writer of exports: a record as summary.json and force-depth.csv, and attempts of a store as plain
// files with checksums, for the trainee or for a study.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/records/samples.h"
#include "app/records/store.h"

namespace stylet::records {

// Everything that is written here is for other programs and for people. No program of Stylet reads it back:
// record.h and samples.h do that from the record.

// summary.json: the record's facts and result. `performance` is added: how the program ran. Throws DataError.
void exportSummary(const RecordInfo& with_result, const nlohmann::ordered_json& performance,
                   const std::filesystem::path& file);

// force-depth.csv: columns tick, time_s, depth_m, force_n, phase, tissue, breath_held. Throws DataError.
void exportCurve(const std::vector<ForceSample>&, double dt_s, const std::filesystem::path& file);

struct ExportResult {
    std::size_t attempts = 0;
    std::vector<std::string> left_out;  // ids of attempts still running
    std::vector<std::string> damage;    // files that differ from what was stored; exported as they are
};

// Writes into `folder`, which must be empty or is created, and makes all of it private:
//   attempts.csv, metrics.csv, events.csv   one line each, keyed by the attempt's id (for the columns, see
//                                           packaging/guide/records.md)
//   attempts/ID/                            the attempt's files, and attempt.json with all its rows
//   checksums.csv                           path, bytes, crc32 of every file of this export
// A text that a spreadsheet would evaluate as a formula gets a leading apostrophe. Exports all trainees if
// `trainee` is empty. Throws DataError.
ExportResult exportAttempts(const Store&, const std::string& trainee, const std::filesystem::path& folder);

// Everything that the store has about the attempt except its files, as one object. "metrics" and "events" are
// lists. `number` and `text` convert the values into a form that the reader of the JSON accepts.
nlohmann::ordered_json attemptJson(const StoredAttempt&, nlohmann::ordered_json (*number)(double),
                                   std::string (*text)(std::string));

}  // namespace stylet::records
