// What the user of a device says besides moving it: words, a line each, and the device's spare buttons.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
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
};

// For a person.
using Say = std::function<void(const std::string&)>;

// Every word with what it does, and what the buttons do.
std::string describeWords();
std::string describe(const UserButtons&);

class UserCommands {
  public:
    UserCommands(const UserButtons& buttons, Say say) : buttons_(buttons), say_(std::move(say)) {}
    // Session thread, as often as it likes. What the whole lines of `typed` ask for (a rest waits for its
    // end) and the buttons just pressed (not the re-arming one), in that order. `now` is the newest tick.
    std::vector<haptics::Command> take(std::string_view typed, std::uint32_t pressed,
                                       const haptics::TickOutput& now);

  private:
    void takeLine(std::string_view line, const haptics::TickOutput&, std::vector<haptics::Command>&);

    UserButtons buttons_;
    Say say_;
    std::string waiting_;
    bool holds_ = false;  // a breath-hold was asked for last
};

// What came of a command in the tick that took it, for a person; empty where there is nothing to say.
std::string outcomeOf(const haptics::Command&, const haptics::TickOutput& before,
                      const haptics::TickOutput& after);

}  // namespace stylet::trainer
