// `stylet run`: runs an attempt, from loading the patient to the summary, with scripted input or with the
// user's device.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/config.h"
#include "app/trainer/stores/start.h"
#include "app/trainer/view/pictures.h"

namespace stylet::trainer {

// The command line. run() resolves it into a configuration.
struct RunOptions {
    // Options that are used as given. run() sets the others from the members below and the store.
    AttemptConfig config;
    // Start of the program. Start-up times are measured from here.
    SteadyTime begun = std::chrono::steady_clock::now();
    // ATTEMPT[@BOOKMARK]: restart that attempt at the bookmark (retry.h), with its patient, seed and tick
    // rate.
    std::string from;
    std::filesystem::path records;  // folder of the store; empty: the user's
    std::string database;           // address of a training centre's database; empty: nothing is sent
    // Frames per simulated second. Default: 0 on the virtual clock; in real time, pictures at the runtime's
    // rate.
    std::optional<double> fps;
    std::string look = "reveal";  // a name in assets/looks, or a .toml file
    // Default: open a mirror window if a display is named, but not with `headless` or `fast`.
    std::optional<bool> mirror;
    // Default: sound, but not with `headless`. Never with `fast`.
    std::optional<bool> sound;
    // One of training::kDifficultyNames. Empty: guided if AttemptWriter::needsGuidance(), else practice.
    std::string difficulty;
};

// Returns the exit status of the command. Throws DataError.
int run(const RunOptions&);

// Opens the pictures that the configuration requests. Sets the fields of `settings` that follow from the
// installation and the attempt; the caller sets the others. On failure, prints one line on stderr: the
// reason, and what the program does instead.
std::unique_ptr<Display> picturesFor(const Attempt&, const patient::PlannedPath&, PictureSettings settings);

}  // namespace stylet::trainer
