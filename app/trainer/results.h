// What an attempt leaves in its folder: summary.json, force-depth curve, slices.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/loops.h"
#include "app/trainer/session.h"
#include "app/trainer/start.h"

namespace stylet::trainer {

struct AttemptFacts {
    std::string patient_name;
    std::filesystem::path patient_folder;
    std::string scenario;
    std::uint64_t seed = 0;
    std::string clock;  // "real time", "virtual", "replay"
    patient::PlannedPath path;
    double dt_s = 0.001;
    std::string device;             // what moved the needle: "scripted", "replay", or a device's name
    std::string firmware_sha256{};  // of the image that the device was given, if any
    std::optional<Start> start{};   // absent: of a replay
};

// Writes summary.json, force-depth.csv, force-depth.png and, when the needle met the body, slices.png.
// Throws patient::DataError.
void writeResults(const patient::Patient&, const AttemptFacts&, const SessionLog&, const LoopTotals&,
                  const std::filesystem::path& folder);

// The few lines a person reads at the end.
void printResults(const AttemptFacts&, const SessionLog&, const LoopTotals&,
                  const std::filesystem::path& folder, bool skips);

}  // namespace stylet::trainer
