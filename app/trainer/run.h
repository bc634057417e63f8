// `stylet run`: an attempt from patient to summary, by a scripted hand or by the user's own on a device.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/trainer/attempt.h"
#include "app/trainer/loops.h"
#include "app/trainer/pictures.h"
#include "app/trainer/start.h"
#include "haptics/devices/devices.h"

namespace stylet::trainer {

struct RunOptions {
    // When the program began: its times of starting count from here.
    SteadyTime begun = std::chrono::steady_clock::now();
    std::string scenario;  // a name in assets/scenarios, or a .toml file; empty: demo, with `from` its own
    // ATTEMPT[@BOOKMARK]: begins with what was done there until then (retry.h), with its patient, seed and
    // rate.
    std::string from;
    std::filesystem::path patient;  // empty: the reference patient of `seed`
    std::filesystem::path full;     // the same patient fully segmented, for the force-truth meter
    std::uint64_t seed = 1;
    std::filesystem::path out;      // with `trainee`: the attempt's folder in the store
    std::string trainee;            // a pseudonym: his attempt is kept in the store
    std::filesystem::path records;  // the store; empty: the user's
    std::string database;           // of a training centre; empty: nothing is sent
    std::string path;               // which one is scored against (reference_path.h)
    double spacing_mm = 1.0;        // of a reference patient made here
    double rate_hz = 1000.0;        // of the haptics loop
    bool headless = false;          // the bundled mock runtime unless XR_RUNTIME_JSON names another
    bool fast = false;              // virtual clock
    std::optional<double> fps;  // virtual clock: frames a simulated second, default 0; real time: 0 = none
    bool stats = false, validation = false;
    std::string look = "reveal";  // or closed
    bool seated = false;          // the room comes down to the eyes of who sits
    bool passthrough = false;     // the real room behind what is drawn, where the headset can
    bool foveation = false;       // fewer rays beside the middle of the view
    // A window for who has no headset on, and in the headset's place where there is none. Default: where a
    // display is named, but not with a mock runtime or a virtual clock.
    std::optional<bool> mirror;
    // Default: sound, but not with a mock runtime. Never on a virtual clock.
    std::optional<bool> sound;
    std::string difficulty;           // training::kDifficultyNames; empty: the first run is guided
    std::optional<double> budget_ms;  // of a frame; default: a GPU keeps to the runtime's pace
    double frame_patience_s = kFramePatience_s;
    // "scripted": the scenario's hand. "replay": the trace's. Else the user's, on a device of that kind or
    // with the mouse in the window, until Ctrl-C or for so many seconds.
    std::string device = "scripted";
    haptics::DeviceOptions device_options;
    std::string hand = "right";  // or left: whose controller has the tool
    std::filesystem::path trace;
    std::optional<double> seconds;
};

// The exit status of the command. Throws patient::DataError.
int run(const RunOptions&);

// Pictures as asked for, or a line on stderr that says why there are none and what happens instead.
std::optional<Pictures> picturesFor(const Attempt&, const patient::PlannedPath&, const RunOptions&,
                                    const std::string& rearm_act = "",
                                    const std::optional<Registration>& = {},
                                    std::shared_ptr<ControllerPort> = nullptr,
                                    std::shared_ptr<Ears> = nullptr, std::shared_ptr<WindowPort> = nullptr);

}  // namespace stylet::trainer
