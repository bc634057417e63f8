// Suggests a rest after long work with a haptic device or a headset without a break. Suggests it only once,
// and never while the needle is in the patient.
#pragma once

#include <span>
#include <string>

namespace stylet::trainer {

// Guidelines for work in a headset ask for a break every 15 to 30 minutes (Esin-M, FlUId VR UI Guidelines).
inline constexpr double kRestAfter_s = 20.0 * 60.0;
inline constexpr double kRest_s = 2.0 * 60.0;  // a break of this length is a rest
inline constexpr double kRestShown_s = 15.0;   // duration of the notice; the console message stays visible

// A period of work. Times are in seconds on any one clock.
struct WorkPeriod {
    double begin_s = 0.0, end_s = 0.0;
};
// Total working time before `now_s` since the last rest. The periods must be in time order.
double sinceRest_s(std::span<const WorkPeriod>, double now_s);

// Session thread. Uses no clock of its own.
class RestWatch {
  public:
    // `already_s`: working time before this attempt, from sinceRest_s().
    explicit RestWatch(double already_s = 0.0) : worked_s_(already_s) {}
    // Call often. `works`: the attempt is running and the user is working. `inside`: the needle is in the
    // body. Returns true once, when a rest should be suggested.
    bool update(double now_s, bool works, bool inside);
    // True while the notice should be visible.
    bool shown() const { return shown_; }
    double worked_s() const { return worked_s_; }

  private:
    double worked_s_, idle_s_ = 0.0, last_s_ = 0.0, suggested_s_ = 0.0;
    bool begun_ = false, suggested_ = false, shown_ = false;
};

// Message for the user.
std::string restAdvice(double worked_s);

}  // namespace stylet::trainer
