// Writes the files of a finished attempt: summary.json, force-depth curve, slices.
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
};

// Writes summary.json, force-depth.csv, force-depth.png and, if the needle entered the body, slices.png.
// Throws DataError.
void writeResults(const patient::Patient&, const AttemptFacts&, const SessionLog&, const LoopTotals&,
                  const std::filesystem::path& folder);

// Prints a short summary for the user.
void printResults(const AttemptFacts&, const SessionLog&, const LoopTotals&,
                  const std::filesystem::path& folder, bool skips);

}  // namespace stylet::trainer
