// The result of an attempt, and the files that are written beside its record when it ends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/loop/loops.h"
#include "app/trainer/session/session.h"
#include "app/trainer/stores/start.h"

namespace stylet::trainer {

struct AttemptFacts {
    std::string patient_name;
    std::filesystem::path patient_folder;
    std::string scenario;
    std::uint64_t seed = 0;
    std::string clock;  // "real time", "virtual", "replay"
    patient::PlannedPath path;
    double dt_s = 0.001;
    std::string device;             // input: "scripted", "replay", or a device's name
    std::string firmware_sha256{};  // hash of the firmware image loaded into the device, if any
    std::optional<Start> start{};   // absent for a replay
    std::string patient_check{};    // as in records::RecordInfo
};

// True if nothing happened that the score or an exam's verdict counts: no decisive event
// (training::isDecisive), no puncture, no X-rays, no injection. Such an attempt is aborted if a user ended
// it. In an exam an answered question about the case counts: otherwise the trainee could end it after a wrong
// answer and keep it out of the statistics.
bool reachedNothing(const SessionLog&, bool exam);

// The result of an attempt, for its record.
// `exam`: it was an exam to its end.
records::AttemptResult makeResult(const patient::Patient&, const SessionLog&, const LoopTotals&, bool exam);

struct Results {
    const patient::Patient& patient;
    const AttemptFacts& facts;
    const records::RecordInfo& record;  // with its result
};

// Exports the record as summary.json and force-depth.csv. Draws force-depth.png and, if the needle entered
// the body, slices.png. Throws DataError.
void writeResults(const Results&, const SessionLog&, const LoopTotals&, const std::filesystem::path& folder);

// Prints a short summary for the user.
void printResults(const AttemptFacts&, const SessionLog&, const LoopTotals&,
                  const std::filesystem::path& folder, bool skips);

}  // namespace stylet::trainer
