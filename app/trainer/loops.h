// The loops of an attempt: haptics at 1 kHz, session, frames. In real time each has its thread; on the
// virtual clock one thread plays all three, tick by tick, with the same calls.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/trainer/attempt.h"
#include "app/trainer/commands.h"
#include "app/trainer/contrast_feed.h"
#include "app/trainer/instructor.h"
#include "app/trainer/pictures.h"
#include "app/trainer/session.h"
#include "haptics/loop.h"

namespace stylet::trainer {

struct LoopTotals {
    haptics::LoopStats haptics;
    double elapsed_s = 0.0;            // by the clock the loop ran on
    std::uint64_t flights_missed = 0;  // faults whose history found the last one not yet taken
    PictureTotals pictures;
    std::optional<NextAttempt> next;  // the instructor has asked for it
    // The runtime has not let go of the last frame. Its thread still uses the attempt's patient: nothing of
    // the attempt may be destroyed.
    bool frames_stuck = false;
};

// The user's hand on a device, in place of the attempt's trace.
struct LiveHand {
    haptics::HapticDevice& device;
    std::function<bool(double elapsed_s)> over;  // session thread, often: the attempt is to end
    std::function<std::string()> typed;          // session thread, often: what was typed since the last time
    std::function<void(haptics::Tool)> hold;     // session thread, often: this is the tool in hand
    UserButtons buttons;
    std::string rearm_act;                                   // what re-arms: "Enter here", ...
    std::function<void(const haptics::TickOutput&)> felt{};  // session thread, often: the newest tick
};

// Time limit for the runtime's last frame, or for opening a new headset session.
inline constexpr double kFramePatience_s = 15.0;

// Haptics, session and frames on threads of their own, frames as fast as the runtime takes them; moments are
// drawn before anything else, and all of them before the loop returns. `clock` must be steady.
// With pictures the force follows the focus: it begins when the headset has it, and goes with it. A live
// attempt ends when the runtime wants the program to end; a scripted one goes on without pictures.
// `heard`: session thread, often: what there is to be seen and heard of the newest tick; `console`: so is
// what an instructor has typed since the last time. `frame_patience_s`: time limit at the end for the
// runtime's last frame, or for opening a new headset session.
LoopTotals runRealTime(const Attempt&, Session&, std::optional<Pictures>, const haptics::Clock& clock,
                       const LiveHand* live = nullptr, const std::function<void(const Seen&)>& heard = {},
                       const std::function<std::string()>& console = {},
                       double frame_patience_s = kFramePatience_s);

// One thread, virtual time; `fps` frames a simulated second besides the moments. The same inputs every time:
// nobody wears the headset, so the focus does not enter. The clock only times the steps.
LoopTotals runFast(const Attempt&, Session&, std::optional<Pictures>, double fps,
                   const haptics::Clock& clock);

}  // namespace stylet::trainer
