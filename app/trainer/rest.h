// When a trainee is told to rest: after so long with a haptic device or in a headset without a break, once,
// and never while the needle is in the patient.
#pragma once

#include <span>
#include <string>

namespace stylet::trainer {

// Guidelines for work in a headset ask for a break every 15 to 30 minutes (Esin-M, FlUId VR UI Guidelines).
inline constexpr double kRestAfter_s = 20.0 * 60.0;
inline constexpr double kRest_s = 2.0 * 60.0;  // so long without it is a rest
inline constexpr double kRestShown_s = 15.0;   // the notice; the console keeps it

// Seconds of one clock, whichever.
struct AtWork {
    double begin_s = 0.0, end_s = 0.0;
};
// How much of these, in order, lies behind `now_s` without a rest between them or after them.
double sinceRest_s(std::span<const AtWork>, double now_s);

// Session thread. Time is an argument.
class RestWatch {
  public:
    // `already_s`: as sinceRest_s() says of the attempts before.
    explicit RestWatch(double already_s = 0.0) : at_it_s_(already_s) {}
    // Often. `works`: the attempt goes on, and somebody holds it; `inside`: the needle is in the body.
    // True once, when the rest is to be suggested.
    bool pass(double now_s, bool works, bool inside);
    // The notice is to be seen.
    bool shown() const { return shown_; }
    double atIt_s() const { return at_it_s_; }

  private:
    double at_it_s_, idle_s_ = 0.0, last_s_ = 0.0, told_s_ = 0.0;
    bool begun_ = false, told_ = false, shown_ = false;
};

// For a person.
std::string restAdvice(double at_it_s);

}  // namespace stylet::trainer
