// Settings of an attempt, resolved once from the command line and the store, then passed as a whole to the
// loops, the pictures and the window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/training/difficulty.h"
#include "haptics/devices/devices.h"
#include "haptics/haptics.h"

namespace stylet::trainer {

// Time limit for the runtime to finish the last frame, or to open a new headset session.
inline constexpr double kFramePatience_s = 15.0;

struct AttemptConfig {
    // Patient and task.
    std::string scenario{};           // name in assets/scenarios, or a .toml file; empty: demo
    std::filesystem::path patient{};  // package; empty: the reference patient of `seed`
    bool accept_implausible = false;  // use a package that `stylet-model check` refused
    std::filesystem::path full{};     // fully segmented package of the same patient, for comparing the force
    std::uint64_t seed = 1;
    double spacing_mm = 1.0;  // voxel size of a generated reference patient
    std::string path{};       // reference path (reference_path.h); empty: the patient's best
    // Names in assets/instruments, or .toml files, that replace the scenario's instruments of the same kinds.
    std::string needle_name{};                    // empty: the scenario's needle
    std::vector<std::string> instrument_names{};  // one of a kind at most
    // The instruments as loaded, once the scenario is known. With a record to restart, those of the record.
    haptics::InstrumentSet instruments{};
    haptics::ToolSettings tools{};
    training::Difficulty difficulty = training::Difficulty::practice;
    training::DifficultyTable difficulties{};  // what each difficulty allows, from the assets
    // What the attempt begins with.
    const training::DifficultyRules& startRules() const noexcept { return difficulties[difficulty]; }

    // Results.
    std::filesystem::path folder{};  // folder for summary, record and captured pictures
    std::string trainee{};           // pseudonym; not empty: the attempt is stored
    bool stats = false;              // count and print skipped work; costs a GPU some additions per ray

    // Time.
    double rate_hz = 1000.0;  // rate of the haptics loop
    bool fast = false;        // virtual clock
    // Frames per simulated second on the virtual clock. In real time the runtime sets the rate. 0: no
    // pictures.
    double fps = 0.0;
    double frame_patience_s = kFramePatience_s;

    // Input. "scripted": the script of the scenario. "replay": the trace. Otherwise live input from a device
    // of that kind, a controller, or the mouse in the window. Live input ends with Ctrl-C or after `seconds`.
    std::string device = "scripted";
    haptics::DeviceOptions device_options{};
    std::string hand = "right";  // or left: the controller that holds the tool
    std::filesystem::path trace{};
    std::optional<double> seconds{};

    // Display and sound.
    bool headless = false;  // use the bundled mock runtime unless XR_RUNTIME_JSON names another
    bool mirror = false;    // open a mirror window, or a window in place of a missing headset
    bool sound = false;
    bool closed_look = false;           // closed skin; false: the anatomy beneath is visible
    std::filesystem::path look_file{};  // look to draw; empty: closed or reveal of the assets
    bool seated = false;                // seated mode: lower the room to the user's eye height
    bool passthrough = false;           // show the real room behind the scene if the headset can
    bool foveation = false;             // fewer rays away from the centre of the view
    bool validation = false;            // Vulkan validation layer; its messages are counted
    // Frame-time budget [ms]; the resolution adapts to it. Absent: the runtime's frame rate on a GPU, no
    // budget on a processor.
    std::optional<double> budget_ms{};
};

}  // namespace stylet::trainer
