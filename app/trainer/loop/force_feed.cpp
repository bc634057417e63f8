#include "app/trainer/loop/force_feed.h"

#include <cstdio>
#include <utility>

#include "app/trainer/loop/loops.h"
#include "base/rings.h"

namespace stylet::trainer {

using haptics::Command;
using haptics::CommandKind;

namespace {

// The start takes a few hundredths of a second. A longer wait needs an action by the user.
constexpr double kPatience_s = 1.0;
// A command reaches a tick one or two ticks after it was sent. One that is not seen within this time was in
// a record that the full ring dropped.
constexpr std::uint64_t kLost_ticks = 500;
constexpr std::size_t kMostWaiting = 16'384;  // characters of typed text

std::string textsOf(std::uint32_t bits) {
    std::string text;
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((bits & fault.bit) != 0) text += (text.empty() ? "" : "; ") + std::string(fault.text);
    return text;
}

}  // namespace

void sayOnStderr(const std::string& text) {
    std::fprintf(stderr, "stylet: %s\n", text.c_str());
}

ForceFeed::ForceFeed(bool focused, double dt_s, const LiveHand* live, Say say,
                     std::function<std::string()> console, bool resumes)
    : live_(live),
      dt_s_(dt_s),
      say_(std::move(say)),
      told_focus_(focused),
      console_(std::move(console)),
      was_paused_(resumes) {
    if (live) user_.emplace(live->buttons, say_);
}

// Instructor commands take effect at once, even during a pause. User commands wait in `typed_`.
void ForceFeed::hear(Session& session) {
    std::string typed;
    if (live_ && typed_.size() < kMostWaiting) typed = live_->typed();
    if (console_) typed += console_();
    if (typed.empty()) return;
    typed_ += instructor_.take(typed);
    if (!live_) typed_.clear();
    for (const Command& command : instructor_.takeCommands()) {
        say_("instructor: " + injectedName(command));
        waiting_.push_back(command);
    }
    for (Instructor::Note& note : instructor_.takeNotes()) {
        say_("instructor: " + note.kind + (note.text.empty() ? "" : ": " + note.text));
        session.note(std::move(note.kind), std::move(note.text));
    }
    if (const auto difficulty = instructor_.takeDifficulty()) session.setDifficulty(*difficulty);
    for (const std::string& refused : instructor_.takeRefused())
        say_("instructor: " + refused);
}

void ForceFeed::pass(bool focused, Session& session, Ring<Command>& ring) {
    hear(session);
    focused = focused && !paused();
    // A device without force, or a script, is re-armed automatically after a pause.
    if (was_paused_ && !paused() && !(live_ && live_->device.profile().force_axes > 0))
        rearm_by_tick_ = session.log().last_tick + kLost_ticks;
    was_paused_ = paused();
    if (focused != told_focus_ && ring.push({CommandKind::focus, focused ? 1u : 0u})) told_focus_ = focused;
    rearmAfterPause(session);
    if (session.takeRearm()) waiting_.push_back({CommandKind::rearm, 0});
    if (const haptics::TickOutput* now = session.newest(); live_ && now) {
        takeWords(session, *now);
        live_->hold(now->tool);
        if (live_->felt) live_->felt(*now);
    }
    while (!waiting_.empty() && ring.push(waiting_.front()))
        waiting_.pop_front();
    tell(session);
}

// The force can be re-armed only once it is off. After a short pause it may still be fading.
void ForceFeed::rearmAfterPause(const Session& session) {
    const haptics::TickOutput* now = session.newest();
    if (!rearm_by_tick_ || !now) return;
    const bool off = now->stage == haptics::ForceStage::off;
    if (off) waiting_.push_back({CommandKind::rearm, 0});
    if (off || paused() || now->tick > *rearm_by_tick_) rearm_by_tick_.reset();
}

// Tool changes are sent one at a time: each depends on the result of the previous one.
void ForceFeed::takeWords(Session& session, const haptics::TickOutput& now) {
    if (changes_at_ && now.tick > *changes_at_ + kLost_ticks) changes_at_.reset();
    if (changes_at_ || !waiting_.empty()) return;
    for (const Command& asked : user_->take(user_->hasLine() ? "" : std::exchange(typed_, {}),
                                            session.takePressed(), now, session.held())) {
        waiting_.push_back(asked);
        if (changesTool(asked)) changes_at_ = now.tick;
    }
}

void ForceFeed::tell(Session& session) {
    for (const Taken& taken : session.takeCommands()) {
        if (changesTool(taken.command)) changes_at_.reset();
        if (const std::string text = outcomeOf(taken.command, taken.before, taken.after);
            live_ && !text.empty())
            say_(text);
    }
    // A full ring does not stop the force. The record says where it ends.
    std::uint32_t faults = session.takeFaults() & ~std::uint32_t(haptics::kFaultRingFull);
    if (paused()) faults &= ~std::uint32_t(haptics::kFaultNotFocused);  // the pause was already reported
    if (live_ && live_->device.profile().force_axes == 0) return;       // input only: no force to report
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((faults & fault.bit) != 0)
            say_("force off: " + std::string(fault.text) + "; re-arm with " +
                 (live_ ? live_->rearm_act : "the device's first button"));
    const SessionLog& log = session.log();
    if (log.awaited == 0) told_awaited_ = 0;
    if (log.awaited == told_awaited_ || double(log.awaited_ticks) * dt_s_ <= kPatience_s) return;
    told_awaited_ = log.awaited;
    say_("force paused: " + textsOf(log.awaited));
}

}  // namespace stylet::trainer
