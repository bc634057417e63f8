// State of an attempt at one tick, as frames show it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "app/trainer/session/force_comparison.h"
#include "app/trainer/session/imaging_input.h"
#include "app/trainer/session/insertion.h"
#include "app/trainer/session/wounds.h"
#include "app/training/attempt_fold.h"
#include "app/training/difficulty.h"
#include "app/training/dose.h"
#include "app/training/equipment.h"
#include "app/training/patient_case.h"
#include "app/training/progress.h"
#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// Strength of the room light's alerts, 0 to 1. `struck`: a risk structure is struck. `reached`: the target is
// reached. The light never flashes (alert.h).
struct Glow {
    float struck = 0.0f, reached = 0.0f;
};

// A tool of the expert: of another attempt in a replay, or of a demonstration.
struct GhostTool {
    haptics::Tool tool = haptics::Tool::needle;
    Pose patient_from_tool;
    double length_m = 0.0;  // of the needle
    // Wire, dilator or drain: where they lie. `patient_from_tool` is then not used.
    std::optional<haptics::AccessOutput> access{};
};

// The scale of a syringe that injects, or has just done so.
struct SyringeScale {
    bool anaesthetic = false;  // else contrast medium
    double injected_m3 = 0.0;  // so far in this attempt
};

struct FrameState {
    haptics::TickOutput tick;
    NeedleShape needle;              // of the attempt
    UltrasoundProbe probe;           // of the attempt
    haptics::AccessSettings access;  // of the attempt: wire, dilator and drain
    std::vector<Wound> wounds;
    training::Equipment equipment;
    training::DoseLedger dose;
    std::vector<patient::Stain> depots{};  // of local anaesthetic
    // See haptics::LoopChannels. `return_distance_m`: distance of the tool from the place where the ticks
    // stopped.
    bool ticks_paused = false;
    double return_distance_m = 0.0;
    std::uint64_t rearm_acts = 0;  // number of re-arm requests so far
    training::Progress progress{};
    std::shared_ptr<const training::PatientCase> patient_case{};  // of a drainage; may be null
    bool lights_out = false;
    bool paused_by_instructor = false;
    Glow glow{};
    Insertion insertion{};                  // tissues that the needle has passed in this insertion
    std::optional<GhostTool> ghost_tool{};  // beside the user's tool
    std::string expert_note{};  // why the expert beside does not show all of this step; for some seconds
    ForceComparisonReading truth{};
    std::optional<training::Difficulty> difficulty{};  // current difficulty, if known
    std::optional<training::Drawn> drawn{};            // by the syringe, a moment ago
    std::optional<SyringeScale> syringe{};
    std::string start_refused{};   // a request for this attempt that was refused, and why; for some seconds
    std::string answer{};          // to the newest command of user or instructor; for some seconds
    bool rest_due = false;         // show the rest notice (rest.h)
    bool input_only = false;       // the user's device exerts no force
    double picture_stall_s = 0.0;  // length of a stall of the picture that is to be reported; 0: none
};

// Force of the tool in hand: of a needle along its shaft, positive against insertion; of another tool the
// magnitude of its force.
inline double toolForce_n(const haptics::TickOutput& tick) {
    return haptics::isNeedleTool(tick.tool) ? tick.force_n : glm::length(tick.tool_force.force_n);
}

}  // namespace stylet::trainer
