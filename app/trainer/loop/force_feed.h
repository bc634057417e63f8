// Passes the user's control of the force to the loop: headset focus, re-arming, typed commands and buttons.
// Reports faults and pauses of the force to the user.
#pragma once

#include <deque>
#include <optional>

#include "app/trainer/attempt/commands.h"
#include "app/trainer/session/instructor.h"
#include "app/trainer/session/session.h"
#include "app/trainer/stores/console.h"
#include "base/rings.h"
#include "haptics/loop/loop.h"

namespace stylet::trainer {

struct LiveHand;

// Session thread only.
class ForceFeed {
  public:
    // `focused`: the focus that the simulation starts with. `live` must outlive this object. `console`
    // returns further typed text, or is null. Without live input, only the instructor's commands in that text
    // are used. `resumes`: start as if a pause had just ended.
    ForceFeed(bool focused, double dt_s, const LiveHand* live = nullptr, Say say = printMessage,
              std::function<std::string()> console = {}, bool resumes = false);
    ForceFeed(const ForceFeed&) = delete;  // its callbacks refer to it
    ForceFeed& operator=(const ForceFeed&) = delete;
    // Sends commands and reports changes. Call after each Session::drain(). `picture_stalled`: the reason for
    // a missing focus is that the picture stands still (picture_watch.h).
    void update(bool focused, Session&, Ring<haptics::Command>&, bool picture_stalled = false);
    // The instructor has paused the attempt.
    bool paused() const { return instructor_.paused(); }
    // Settings of the next attempt, once the instructor has requested one.
    const std::optional<NextAttempt>& next() const { return instructor_.next(); }
    // The instructor has ended the attempt as aborted.
    bool aborted() const { return instructor_.aborted(); }

  private:
    void readInput(Session&);
    void refuseUserCommands();
    void sendInstructorCommand(const haptics::Command&);
    void answer(std::string text);
    void rearmAfterPause(const Session&);
    void sendUserCommands(Session&, const haptics::TickOutput& now);
    std::string snap(const Session&, const haptics::TickOutput& now);
    void report(Session&);
    std::string describeFaults(std::uint32_t bits) const;
    void reportQuestion(const training::PatientCase&, int answered);
    bool isInputOnly() const;

    const LiveHand* live_;
    double dt_s_;
    Say say_;  // prints on the terminal
    bool sent_focus_;
    std::function<std::string()> console_;
    Instructor instructor_;
    std::string typed_;   // pending user commands
    std::string answer_;  // the newest, not yet in the window
    bool was_paused_ = false;
    // Set after a pause: last tick for re-arming. The force may still be fading until then.
    std::optional<std::uint64_t> rearm_by_tick_;
    std::optional<UserCommands> user_;
    std::deque<haptics::Command> waiting_;     // waiting for space in the ring
    std::optional<std::uint64_t> changes_at_;  // a tool change was sent after this tick and is still pending
    std::uint32_t reported_awaited_ = 0;
    int reported_question_ = -1;
    bool picture_stalled_ = false;
};

}  // namespace stylet::trainer
