#include "app/trainer/loop/force_feed.h"

#include <fmt/core.h>
#include <utility>

#include "app/trainer/hands/snap.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/session/flight.h"
#include "base/rings.h"

namespace stylet::trainer {

using haptics::Command;
using haptics::CommandKind;

namespace {

// The force normally starts within a few hundredths of a second. A longer wait needs an action by the user.
constexpr double kPatience_s = 1.0;
// A command is executed one or two ticks after it was sent. If no tick shows it within this time, a full ring
// dropped the record of that tick.
constexpr std::uint64_t kLost_ticks = 500;
constexpr std::size_t kMaxWaiting = 16'384;  // characters of pending text

}  // namespace

ForceFeed::ForceFeed(bool focused, double dt_s, const LiveHand* live, Say say,
                     std::function<std::string()> console, bool resumes)
    : live_(live),
      dt_s_(dt_s),
      say_(std::move(say)),
      sent_focus_(focused),
      console_(std::move(console)),
      was_paused_(resumes) {
    if (live)
        user_.emplace(live->buttons, [this](const std::string& text) { answer(text); }, !isInputOnly(), dt_s);
}

bool ForceFeed::isInputOnly() const {
    return live_ && haptics::isInputOnly(live_->device.profile());
}

// Instructor commands take effect at once, even during a pause. User commands wait in `typed_`.
void ForceFeed::readInput(Session& session) {
    std::string typed;
    if (live_ && typed_.size() < kMaxWaiting) typed = live_->typed();
    if (console_) typed += console_();
    if (typed.empty()) return;
    typed_ += instructor_.processLines(typed);
    if (!live_) refuseUserCommands();
    for (const Command& command : instructor_.popCommands())
        sendInstructorCommand(command);
    for (Instructor::Note& note : instructor_.popNotes()) {
        answer("instructor: " + note.kind + (note.text.empty() ? "" : ": " + note.text));
        session.note(std::move(note.kind), std::move(note.text));
    }
    if (const auto difficulty = instructor_.popDifficulty()) session.setDifficulty(*difficulty);
    for (const std::string& text : instructor_.popAnswers())
        answer("instructor: " + text);
}

// Without live input, no user controls a tool. One answer is enough for any number of lines.
void ForceFeed::refuseUserCommands() {
    std::string typed = std::exchange(typed_, {}) + '\n', line;
    while (line.empty() && !typed.empty())
        line = popLine(typed).value_or("");
    if (line.empty()) return;
    answer(fmt::format("instructor: \"{}\" is not an instructor's command: see \"stylet run --help\"",
                       line.substr(0, 40)));
}

// The answer follows once a tick has executed the command (report()).
void ForceFeed::sendInstructorCommand(const Command& command) {
    const std::string name = injectedName(command);
    if (command.kind == CommandKind::fault && isInputOnly())
        return answer(
            fmt::format("instructor: {}: not done, because this input has no force that could fail", name));
    if (paused()) answer(fmt::format("instructor: {}: waits until the attempt resumes", name));
    waiting_.push_back(command);
}

// On the terminal and in the window. A list is too long for the window.
void ForceFeed::answer(std::string text) {
    say_(text);
    answer_ = text.find('\n') == std::string::npos ? std::move(text) : "the list is on the terminal";
}

void ForceFeed::update(bool focused, Session& session, Ring<Command>& ring, bool picture_stalled) {
    picture_stalled_ = picture_stalled;
    readInput(session);
    focused = focused && !paused();
    // After a pause, a script or a device without force output is re-armed automatically.
    if (was_paused_ && !paused() && (!live_ || isInputOnly()))
        rearm_by_tick_ = session.log().last_tick + kLost_ticks;
    was_paused_ = paused();
    if (focused != sent_focus_ && ring.push({CommandKind::focus, focused ? 1u : 0u})) sent_focus_ = focused;
    rearmAfterPause(session);
    if (session.popRearm()) waiting_.push_back({CommandKind::rearm, 0});
    if (const haptics::TickOutput* now = session.newest(); live_ && now) {
        sendUserCommands(session, *now);
        live_->set_tool(now->tool);
        if (live_->felt) live_->felt(*now);
    }
    while (!waiting_.empty() && ring.push(waiting_.front()))
        waiting_.pop_front();
    report(session);
    if (!answer_.empty()) session.showAnswer(std::exchange(answer_, {}));
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
void ForceFeed::sendUserCommands(Session& session, const haptics::TickOutput& now) {
    if (changes_at_ && now.tick > *changes_at_ + kLost_ticks) changes_at_.reset();
    if (changes_at_ || !waiting_.empty()) return;
    const training::Progress& progress = session.log().progress;
    user_->setCourse(progress.course);
    user_->setQuestion(progress.step == training::Step::reviewCase ? std::optional(progress.answered)
                                                                   : std::nullopt);
    if (progress.step == training::Step::reviewCase)
        reportQuestion(*session.patientCase(), progress.answered);
    user_->setNumbing(training::hasAnaesthesia(progress.course) && !progress.success &&
                      !training::contains(progress.steps_done, training::Step::incise));
    for (const Command& asked : user_->update(user_->hasLine() ? "" : std::exchange(typed_, {}),
                                              session.popPressed(), now, session.buttonsDown())) {
        waiting_.push_back(asked);
        if (changesTool(asked)) changes_at_ = now.tick;
    }
    if (user_->popExpert() && live_->expert) answer(live_->expert());
    if (user_->popSnap()) answer(snap(session, now));
}

// The case once, and each question.
void ForceFeed::reportQuestion(const training::PatientCase& patient_case, int answered) {
    if (answered == reported_question_) return;
    if (reported_question_ < 0)
        for (const std::string& line : training::describeCase(patient_case))
            say_("case: " + line);
    reported_question_ = answered;
    say_(fmt::format("question {} of {}: {}", answered + 1, training::kQuestionCount,
                     questionText(training::Question(answered))));
}

// Returns what the user should know. A device with a button for it moves a tool that touches nothing back to
// the hand as soon as that button is up.
std::string ForceFeed::snap(const Session& session, const haptics::TickOutput& now) {
    std::string why_not =
        live_->snap ? live_->snap(now) : "only the mouse and controllers are placed: move the device";
    const std::uint32_t button = live_->buttons.snap;
    const bool returns = button != 0 && !touchesPatient(now);
    if (why_not.empty() && returns && (session.buttonsDown() & button) == 0)
        why_not = "hold the trigger until the tool is there";
    if (!why_not.empty()) return "not placed on the skin: " + why_not;
    return returns ? "the tool moves to the skin while you hold the trigger" : "the tool moves to the skin";
}

void ForceFeed::report(Session& session) {
    for (const ExecutedCommand& executed : session.popCommands()) {
        if (changesTool(executed.command)) changes_at_.reset();
        if (const std::string text = describeOutcome(executed.command, executed.before, executed.after);
            live_ && !text.empty())
            answer(text);
    }
    for (const std::string& text : session.popInjected())
        answer("instructor: " + text);
    // A full ring does not stop the force, so it is not reported here. The record shows where it ends.
    std::uint32_t faults = session.popFaults() & ~std::uint32_t(haptics::kFaultRingFull);
    if (paused()) faults &= ~std::uint32_t(haptics::kFaultNotFocused);  // the pause was already reported
    if (isInputOnly()) return;                                          // no force to report
    for (const haptics::FaultText& fault : haptics::faultTexts())
        if ((faults & fault.bit) != 0)
            say_(fmt::format("force off: {}; re-arm with {}", describeFaults(fault.bit),
                             live_ ? live_->rearm_act : "the device's first button"));
    const SessionLog& log = session.log();
    if (log.awaited == 0) reported_awaited_ = 0;
    if (log.awaited == reported_awaited_ || double(log.awaited_ticks) * dt_s_ <= kPatience_s) return;
    reported_awaited_ = log.awaited;
    say_("force paused: " + describeFaults(log.awaited));
}

// The loop cannot tell a stalled picture from a lost focus: it gets the same command.
std::string ForceFeed::describeFaults(std::uint32_t bits) const {
    std::string text;
    if (picture_stalled_ && (bits & haptics::kFaultNotFocused) != 0) {
        bits &= ~std::uint32_t(haptics::kFaultNotFocused);
        text = "the picture has stopped";
        if (bits != 0) text += "; ";
    }
    return text + joinFaults(bits, "; ", &haptics::FaultText::text);
}

}  // namespace stylet::trainer
