// Where a replay is: played, stopped, slow or fast, scrubbed. No clock, no thread: time is an argument.
#pragma once

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

}  // namespace stylet::trainer
