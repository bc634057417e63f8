// What the user of a device says besides moving it: words, a line each, and the device's spare buttons.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/simulation.h"

namespace stylet::trainer {

// Bits of DeviceState::buttons; 0 where the device has none left for it.
struct UserButtons {
    std::uint32_t rearm = 1u << 0;  // the force again after a fault
    std::uint32_t next = 0;         // the procedure's next tool; a probe in hand is parked before
    std::uint32_t breath = 0;       // a breath-hold, or its end
    std::uint32_t pedal = 0;        // X-rays for as long as it is held
    std::uint32_t inject = 0;       // contrast medium, likewise
};

// For a person.
using Say = std::function<void(const std::string&)>;

// Every word with what it does, and what the buttons do: those of these names, from the first bit on.
std::string describeWords();
std::string describe(const UserButtons&, std::span<const std::string_view> names = {});

class UserCommands {
  public:
    UserCommands(const UserButtons& buttons, Say say) : buttons_(buttons), say_(std::move(say)) {}
    // Session thread. What the whole lines of `typed` ask for (a rest waits for its end) and the buttons just
    // pressed (not the re-arming one), in that order, up to the first command that changes the tool: what
    // follows it waits for the next call, and so does what the buttons say that are `held`. `now` is the
    // newest tick, and knows what came of the last such one.
    std::vector<haptics::Command> take(std::string_view typed, std::uint32_t pressed,
                                       const haptics::TickOutput& now, std::uint32_t held = 0);
    // A whole line waits: no more need be read.
    bool hasLine() const { return waiting_.find('\n') != std::string::npos; }

  private:
    void add(const haptics::Command&, std::vector<haptics::Command>&);
    void addNext(const haptics::TickOutput&, std::vector<haptics::Command>&);
    void takeLine(std::string_view line, const haptics::TickOutput&, std::vector<haptics::Command>&);

    UserButtons buttons_;
    Say say_;
    std::string waiting_;
    std::uint32_t pressed_ = 0, holding_ = 0;
    bool next_wanted_ = false;  // once the probe is parked
    bool begun_ = false;
    bool holds_ = false;  // a breath-hold was asked for last, and he has not given up
    bool held_ = false;   // so in the newest tick
};

// It decides which tool is in hand, or whether the probe stays.
constexpr bool changesTool(const haptics::Command& c) {
    return c.kind == haptics::CommandKind::tool || c.kind == haptics::CommandKind::park;
}

// What came of a command in the tick that took it, for a person; empty where there is nothing to say.
std::string outcomeOf(const haptics::Command&, const haptics::TickOutput& before,
                      const haptics::TickOutput& after);

}  // namespace stylet::trainer
