// What a picture shows of an attempt at a tick.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/trainer/force_truth.h"
#include "app/trainer/insertion.h"
#include "app/trainer/wounds.h"
#include "app/training/difficulty.h"
#include "app/training/dose.h"
#include "app/training/machines.h"
#include "app/training/progress.h"
#include "haptics/simulation.h"

namespace stylet::trainer {

// How much the room says that a structure at risk is struck, or that the target is reached: 0 to 1, and
// never in a flash (alert.h).
struct Glow {
    float struck = 0.0f, reached = 0.0f;
};

struct Seen {
    haptics::TickOutput tick;
    std::vector<Wound> wounds;
    training::Machines machines;
    training::DoseLedger dose;
    // As haptics::LoopChannels has them: no ticks are made, and how far the tool is from where they stopped.
    bool held = false;
    double to_return_m = 0.0;
    std::uint64_t rearm_acts = 0;  // how often the user has asked for the force, so far
    training::Progress progress{};
    bool lights_out = false;
    bool paused = false;  // by the instructor
    Glow glow{};
    Insertion insertion{};                        // what the needle has passed, this time
    std::optional<patient::Pose> ghost_needle{};  // of an expert's attempt, in a replay
    ForceTruthReading truth{};
    std::optional<training::Difficulty> difficulty{};  // as the instructor has set it, if he has
    bool rest_due = false;                             // the trainee is to be told so (rest.h)
};

}  // namespace stylet::trainer
