// The loops of an attempt: haptics at 1 kHz, session, frames. In real time each has its own thread. On the
// virtual clock one thread runs all three tick by tick, with the same calls.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/commands.h"
#include "app/trainer/attempt/config.h"
#include "app/trainer/session/contrast_feed.h"
#include "app/trainer/session/instructor.h"
#include "app/trainer/session/session.h"
#include "app/trainer/view/pictures.h"
#include "haptics/loop/loop.h"

namespace stylet::trainer {

struct LoopTotals {
    haptics::LoopStats haptics;
    double elapsed_s = 0.0;            // measured with the loop's clock
    std::uint64_t flights_missed = 0;  // fault recordings dropped: the previous one was not consumed
    bool input_only = false;           // the user's device exerts no force
    bool live = false;                 // a user ended the attempt; a script ends by itself
    bool aborted = false;              // by the instructor
    PictureTotals pictures;
    std::optional<NextAttempt> next;  // set if the instructor requested it
    // The runtime did not return from the last frame. Its thread still uses the attempt's patient, so
    // nothing of the attempt may be destroyed.
    bool frames_stuck = false;
};

// Live input from a device, in place of the attempt's trace.
struct LiveHand {
    haptics::HapticDevice& device;
    std::function<bool(double elapsed_s)> over;   // session thread, often: true ends the attempt
    std::function<std::string()> typed;           // session thread, often: text typed since the last call
    std::function<void(haptics::Tool)> set_tool;  // session thread, often: the tool in use
    UserButtons buttons;
    std::string rearm_act;                                   // how the user re-arms, for example "Enter"
    std::function<void(const haptics::TickOutput&)> felt{};  // session thread, often: the newest tick
    // Session thread. Has the device place the tool on the skin (snap.h). Returns why it cannot; empty if it
    // does. Null for a device that exerts force.
    std::function<std::string(const haptics::TickOutput&)> snap{};
    // Session thread. Shows the expert beside the user's tool, or no longer (demonstration.h). Returns what
    // the user should know.
    std::function<std::string()> expert{};
};

// Optional parts of a real-time attempt.
struct RealTimeOptions {
    const LiveHand* live = nullptr;                     // null: the attempt's scripted input
    std::function<void(const FrameState&)> on_state{};  // session thread, often: the newest state, for sound
    // Session thread, often: adds to the newest state what helps the user.
    std::function<void(FrameState&)> help{};
    std::function<std::string()> console{};      // session thread, often: text that an instructor has typed
    double frame_patience_s = kFramePatience_s;  // see AttemptConfig
};

// Runs haptics, session and frames on their own threads. Frames run at the runtime's rate. Captures have
// priority over live frames, and all of them are drawn before the function returns. `clock` must be steady.
// With pictures, the force follows the headset's focus: it starts when the headset gains focus and ends when
// the headset loses it. A live attempt ends when the runtime asks the program to end. A scripted attempt
// continues without pictures.
LoopTotals runRealTime(const Attempt&, Session&, std::unique_ptr<Display>, const haptics::Clock& clock,
                       const RealTimeOptions& = {});

// Runs everything on one thread in virtual time. Draws `fps` frames per simulated second in addition to the
// captures. The focus is ignored, so the inputs are the same in every run. `clock` only measures how long the
// steps take.
LoopTotals runFast(const Attempt&, Session&, std::unique_ptr<Display>, double fps,
                   const haptics::Clock& clock);

}  // namespace stylet::trainer
