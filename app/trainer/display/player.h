// Playback state of a replay: position, speed, playing or stopped. It has no clock and no thread; the caller
// passes the elapsed time.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "app/trainer/hands/window_port.h"

namespace stylet::trainer {

class Player {
  public:
    explicit Player(double length_s) { state_.length_s = length_s; }

    // Executes whole command lines: "toggle", "stop", "skip S" (seconds; negative: back), "seek SHARE"
    // (fraction of the length), "speed FACTOR" (multiplies the speed). Ignores other lines.
    void execute(std::string lines);
    // Advances by `dt_s` of wall-clock time. Stops at the end. At the end, "toggle" plays again from the
    // start.
    void advance(double dt_s);
    const Playback& state() const { return state_; }

    static constexpr double kSlowest = 1.0 / 16.0, kFastest = 16.0;

  private:
    void executeLine(std::string_view line);
    void goTo(double at_s);

    Playback state_;
};

// Playback control with a headset controller. Moving the stick to the right or left scrubs; more deflection
// scrubs faster. A push up or down doubles or halves the speed once. The trigger plays and stops, the second
// button goes to the start, and the grip button goes back by five seconds.
class PlayerStick {
  public:
    // `buttons`: see controllerButtons(). `stick`: right and up in [-1, 1]. `dt_s`: time since the last
    // call. Returns command lines for Player::execute.
    std::string update(std::uint32_t buttons, const std::array<float, 2>& stick, double dt_s);

    static constexpr float kRest = 0.25f, kFlick = 0.7f;
    // Largest scrub speed [s of the replay per second], and the jump of the grip button.
    static constexpr double kFastest_s = 12.0, kBack_s = 5.0;

  private:
    std::uint32_t buttons_ = ~0u;  // a button that is down at the start does not count as pressed
    bool flicked_ = false;
};

}  // namespace stylet::trainer
