// Where a replay is: played, stopped, slow or fast, scrubbed. No clock, no thread: time is an argument.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "app/trainer/window_port.h"

namespace stylet::trainer {

class Player {
  public:
    explicit Player(double length_s) { state_.length_s = length_s; }

    // Whole lines: "toggle", "stop", "skip S" (seconds, < 0: back), "seek SHARE" (of the length), "speed
    // FACTOR" (times what it is). Others change nothing.
    void hear(std::string_view lines);
    // `dt_s` of the viewer's time later. At its end it stops; played again from there, it begins anew.
    void pass(double dt_s);
    const Playback& state() const { return state_; }

    static constexpr double kSlowest = 1.0 / 16.0, kFastest = 16.0;

  private:
    void hearLine(std::string_view line);
    void goTo(double at_s);

    Playback state_;
};

// A controller as the player's hand. Its stick, pushed right or left, scrubs, the further the faster; pushed
// up or down once it doubles or halves the speed. The trigger plays and stops, the second button goes to the
// begin, the grip back by five seconds.
class PlayerStick {
  public:
    // As of controllerButtons() and the stick, right and up in [-1, 1]; `dt_s` after the last call. What it
    // says to Player::hear.
    std::string take(std::uint32_t buttons, const std::array<float, 2>& stick, double dt_s);

    static constexpr float kRest = 0.25f, kFlick = 0.7f;
    static constexpr double kFastest_s = 12.0, kBack_s = 5.0;  // of the attempt in a second; at once

  private:
    std::uint32_t buttons_ = ~0u;  // what is held as it begins was not pressed
    bool flicked_ = false;
};

}  // namespace stylet::trainer
