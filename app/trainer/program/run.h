// `stylet run`: runs an attempt, from loading the patient to the summary, with scripted input or with the
// user's device.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/stores/start.h"
#include "app/trainer/view/pictures.h"
#include "haptics/devices/devices.h"

namespace stylet::trainer {

struct RunOptions {
    // Start of the program; start-up times count from here.
    SteadyTime begun = std::chrono::steady_clock::now();
    // Name in assets/scenarios, or a .toml file; empty: demo, with `from` the recorded one.
    std::string scenario;
    // ATTEMPT[@BOOKMARK]: restart that attempt at the bookmark (retry.h), with its patient, seed and tick
    // rate.
    std::string from;
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::filesystem::path full;     // fully segmented package of the same patient, to compare the force
    std::uint64_t seed = 1;
    std::filesystem::path out;      // with `trainee`: the attempt's folder in the store
    std::string trainee;            // pseudonym; the attempt is kept in the store
    std::filesystem::path records;  // folder of the store; empty: the user's
    std::string database;           // of a training centre; empty: nothing is sent
    std::string path;               // reference path (reference_path.h); empty: the patient's best
    double spacing_mm = 1.0;        // voxel size of a generated reference patient
    double rate_hz = 1000.0;        // of the haptics loop
    bool headless = false;          // use the bundled mock runtime unless XR_RUNTIME_JSON names another
    bool fast = false;              // virtual clock
    // Virtual clock: frames per simulated second, default 0. Real time: 0 means no pictures.
    std::optional<double> fps;
    bool stats = false, validation = false;
    std::string look = "reveal";  // or closed
    bool seated = false;          // seated mode: lower the room to the user's eye height
    bool passthrough = false;     // show the real room behind the scene if the headset can
    bool foveation = false;       // fewer rays away from the centre of the view
    // Open a mirror window, or a window in place of a missing headset. Default: if a display is named, but
    // not with `headless` or `fast`.
    std::optional<bool> mirror;
    // Default: sound, but not with `headless`. Never with `fast`.
    std::optional<bool> sound;
    // One of training::kDifficultyNames; empty: guided in a trainee's first run, else practice.
    std::string difficulty;
    std::optional<double> budget_ms;  // frame-time budget; default: the runtime's frame rate on a GPU
    double frame_patience_s = kFramePatience_s;
    // "scripted": the scenario's input. "replay": the trace. Otherwise live input from a device of that
    // kind, from a controller or from the mouse in the window, until Ctrl-C or for `seconds`.
    std::string device = "scripted";
    haptics::DeviceOptions device_options;
    std::string hand = "right";  // or left: the controller that holds the tool
    std::filesystem::path trace;
    std::optional<double> seconds;
};

// Returns the exit status of the command. Throws DataError.
int run(const RunOptions&);

// Opens the pictures that were requested. If that fails, prints one line on stderr with the reason and what
// happens instead.
std::optional<Pictures> picturesFor(const Attempt&, const patient::PlannedPath&, const RunOptions&,
                                    const std::string& rearm_act = "",
                                    const std::optional<Registration>& = {},
                                    std::shared_ptr<ControllerPort> = nullptr,
                                    std::shared_ptr<Ears> = nullptr, std::shared_ptr<WindowPort> = nullptr);

}  // namespace stylet::trainer
