// What the user does about the force, and what he is told of it: the focus as the frame loop sees it, the act
// of re-arming, on a device his words and buttons; faults, and what the force waits for.
#pragma once

#include <deque>
#include <optional>

#include "app/trainer/commands.h"
#include "app/trainer/instructor.h"
#include "app/trainer/session.h"
#include "haptics/loop.h"

namespace stylet::trainer {

struct LiveHand;

// A line on stderr, "stylet: ".
void sayOnStderr(const std::string&);

// Session thread, all of it.
class ForceFeed {
  public:
    // `focused` is what the simulation has been told. A live hand must outlive it. `console`: what is typed
    // besides, or null; where nobody's hand is live only the instructor's words count. `resumes`: it begins
    // as if a pause had just ended.
    ForceFeed(bool focused, double dt_s, const LiveHand* live = nullptr, Say say = sayOnStderr,
              std::function<std::string()> console = {}, bool resumes = false);
    // Commands out, news told; after each Session::drain().
    void pass(bool focused, Session&, haptics::Ring<haptics::Command>&);
    // The instructor lets the attempt stand still.
    bool paused() const { return instructor_.paused(); }
    // He has asked for another attempt.
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
    std::string typed_;  // for the user's hand
    bool was_paused_ = false;
    std::optional<std::uint64_t> rearm_by_tick_;  // a pause is over, and the force may still be fading
    std::optional<UserCommands> user_;
    std::deque<haptics::Command> waiting_;     // for room in the ring
    std::optional<std::uint64_t> changes_at_;  // a tool's change was sent after this tick and is not seen yet
    std::uint32_t told_awaited_ = 0;
};

}  // namespace stylet::trainer
