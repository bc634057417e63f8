// Passes the user's control of the force to the loop (headset focus, re-arming, typed commands and buttons)
// and reports faults and pauses of the force to the user.
#pragma once

#include <deque>
#include <optional>

#include "app/trainer/attempt/commands.h"
#include "app/trainer/session/instructor.h"
#include "app/trainer/session/session.h"
#include "base/rings.h"
#include "haptics/loop/loop.h"

namespace stylet::trainer {

struct LiveHand;

// Prints a line on stderr, after "stylet: ".
void sayOnStderr(const std::string&);

// Session thread only.
class ForceFeed {
  public:
    // `focused` is the focus the simulation already knows. `live` must outlive this object. `console`
    // returns further typed text, or is null; without a live hand only the instructor's commands in it
    // count. `resumes`: start as if a pause had just ended.
    ForceFeed(bool focused, double dt_s, const LiveHand* live = nullptr, Say say = sayOnStderr,
              std::function<std::string()> console = {}, bool resumes = false);
    // Sends commands and reports news. Call after each Session::drain().
    void pass(bool focused, Session&, Ring<haptics::Command>&);
    // The instructor has paused the attempt.
    bool paused() const { return instructor_.paused(); }
    // The next attempt, once the instructor has requested one.
    const std::optional<NextAttempt>& next() const { return instructor_.next(); }

  private:
    void hear(Session&);
    void rearmAfterPause(const Session&);
    void takeWords(Session&, const haptics::TickOutput& now);
    void tell(Session&);

    const LiveHand* live_;
    double dt_s_;
    Say say_;
    bool told_focus_;
    std::function<std::string()> console_;
    Instructor instructor_;
    std::string typed_;  // pending user commands
    bool was_paused_ = false;
    std::optional<std::uint64_t> rearm_by_tick_;  // a pause has ended; the force may still be fading
    std::optional<UserCommands> user_;
    std::deque<haptics::Command> waiting_;     // waiting for space in the ring
    std::optional<std::uint64_t> changes_at_;  // a tool change was sent after this tick and is still pending
    std::uint32_t told_awaited_ = 0;
};

}  // namespace stylet::trainer
