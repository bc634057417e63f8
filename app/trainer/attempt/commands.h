// User commands besides motion: typed lines and the device's spare buttons.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/training/progress.h"
#include "haptics/loop/simulation.h"

namespace stylet::trainer {

// Bits of DeviceState::buttons; 0 if the device has no button for that function.
struct UserButtons {
    std::uint32_t rearm = 1u << 0;  // re-arms the force after a fault
    // The procedure's next tool; a probe in use is parked first. Pressed for kLiftAfter_s, it picks up the
    // parked probe, which the order of tools passes over.
    std::uint32_t next = 0;
    // Lets go of the tool on the track of an access while pressed, to move the hand back. May be the button
    // that re-arms, because nothing is held while the force is off.
    std::uint32_t regrip = 0;
    std::uint32_t breath = 0;  // starts or ends a breath-hold
    std::uint32_t pedal = 0;   // X-rays while pressed
    // Contrast medium while pressed; in a drainage local anaesthetic, until the incision or the puncture is
    // done.
    std::uint32_t inject = 0;
    std::uint32_t aspirate = 0;  // draws with a syringe at the needle
    std::uint32_t snap = 0;      // places the tool on the skin beneath it, while pressed
    std::uint32_t expert = 0;    // shows the expert beside the tool, or no longer
};

// Prints a message for the user.
using Say = std::function<void(const std::string&)>;

// Help texts: all typed commands of a course; all assigned buttons. `names` are the button names, from bit 0
// on. Without `exerts_force`, the commands about the force are left out.
std::string describeCommands(bool exerts_force = true, training::Course = training::kDefaultCourse);
std::string describe(const UserButtons&, std::span<const std::string_view> names = {},
                     training::Course = training::kDefaultCourse);

class UserCommands {
  public:
    static constexpr double kLiftAfter_s = 1.0, kReadQuestion_s = 0.5;

    // `exerts_force`: false for a device without force, which has nothing to re-arm. `dt_s`: of a tick.
    UserCommands(const UserButtons& buttons, Say say, bool exerts_force = true, double dt_s = 0.001)
        : buttons_(buttons), say_(std::move(say)), exerts_force_(exerts_force), dt_s_(dt_s) {}
    // Of the attempt; without this call, kDefaultCourse, which has no local anaesthesia.
    void setCourse(training::Course course) { course_ = course; }
    // The button that injects starts local anaesthetic instead of contrast medium, and the needle comes
    // before the scalpel in the order of tools.
    void setNumbing(bool numbing) { numbing_ = numbing; }
    // The question about the case that is open, counted from 0, if any: the button of the breath-hold answers
    // yes, that of the next tool no. An answer is refused until the question has been open for
    // kReadQuestion_s, because the user may not have seen it yet.
    void setQuestion(std::optional<int> question) { question_ = question; }
    // Session thread. Returns the commands of all complete lines in `typed` and of the newly pressed buttons
    // (`pressed`, without the re-arm button), in that order. An incomplete line waits for its newline. Stops
    // after the first command that changes the tool: later lines and buttons wait for the next call. `now` is
    // the newest tick and must already reflect the last such command. Refuses what a syringe cannot do
    // without a needle in the body.
    std::vector<haptics::Command> update(std::string_view typed, std::uint32_t pressed,
                                         const haptics::TickOutput& now, std::uint32_t buttons_down = 0);
    // True once for each request to place the tool on the skin (snap.h), or to show the expert or no longer
    // (demonstration.h). These are no commands to the ticks.
    bool popSnap() { return std::exchange(snap_, false); }
    bool popExpert() { return std::exchange(expert_, false); }
    // A complete line is pending, so no more input need be read.
    bool hasLine() const { return waiting_.find('\n') != std::string::npos; }

  private:
    void add(const haptics::Command&, const haptics::TickOutput&, std::vector<haptics::Command>&);
    void addInjection(bool down, const haptics::TickOutput&, std::vector<haptics::Command>&);
    void addAnswer(const haptics::Command&, const haptics::TickOutput&, std::vector<haptics::Command>&);
    void addNext(const haptics::TickOutput&, std::vector<haptics::Command>&);
    bool liftsProbe(const haptics::TickOutput&, std::uint32_t buttons_down);
    void answerByButton(const haptics::TickOutput&, std::vector<haptics::Command>&);
    void parseLine(std::string_view line, const haptics::TickOutput&, std::vector<haptics::Command>&);

    UserButtons buttons_;
    Say say_;
    bool exerts_force_;
    double dt_s_;
    bool numbing_ = false;
    std::optional<int> question_, asked_;  // now, and in the last update
    std::uint64_t asked_at_ = 0;           // tick at which the question was opened or last answered
    bool injects_ = false;                 // by the button
    bool flows_ = false;                   // a syringe injects
    training::Course course_ = training::kDefaultCourse;
    std::string waiting_;
    std::uint32_t pressed_ = 0, last_buttons_down_ = 0;
    bool next_wanted_ = false;              // pending until the probe is parked
    std::optional<std::uint64_t> lift_at_;  // tick at which `next` will have been pressed long enough
    bool begun_ = false;
    bool hold_requested_ = false;  // the last request was a breath-hold and the patient still holds
    bool breath_held_ = false;     // breath-hold in the newest tick
    bool snap_ = false, expert_ = false;
};

// True for commands that change the tool, or park or lift the probe.
constexpr bool changesTool(const haptics::Command& c) {
    return c.kind == haptics::CommandKind::tool || c.kind == haptics::CommandKind::park;
}

// Result of a command as a message for the user, from the ticks before and after it. Empty if there is
// nothing to report.
std::string describeOutcome(const haptics::Command&, const haptics::TickOutput& before,
                            const haptics::TickOutput& after);

}  // namespace stylet::trainer
