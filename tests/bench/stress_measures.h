// What the campaign asks of a run. Everything is judged by the truth of the simulated device, at the motor
// and the tip, not by what the controller believes.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/haptics.h"
#include "tests/support/simulated_device.h"

namespace stylet::stress {

using haptics::Vec3;

// Limits, each with its reason.
inline constexpr double kStep_n = 0.145;  // perceptible, the study's threshold
// A fingertip feels 10 to 30 um at 20 to 50 Hz. Two and a half encoder counts are added, five from end to
// end: an edge is lost at each turn, and a pace needs two more. Swings of up to 2.4 counts were seen whose
// size did not change with the controller's gain (weak devices, bare, without any friction, 0.02 N): only the
// device's own friction can end what stays within the encoder (K <= 2 f_c / Delta).
inline constexpr double kCycle_m = 20e-6, kCycle_counts = 2.5;
// Fed by more than the device's own damping and friction take, and by more than so much of its energy a
// second: else it dies away, if slowly.
inline constexpr double kFed_per_s = 0.2;
inline constexpr double kCycle_hz = 5.0;  // below it is a hand's own swaying
inline constexpr double kCycleWindow_s =
    1.0;  // the last of a case, a second or more after the hand came to rest

// An oscillation that lasts.
struct Cycle {
    double amplitude_m = 0.0, hz = 0.0;
    bool lasts = false;  // wider than asked, faster than kCycle_hz, and not dying away
};
// Of an evenly sampled position. What is slower than kCycle_hz is taken off first.
Cycle findCycle(const std::vector<double>& position_m, double dt_s, double wide_m = kCycle_m);

// Energy that comes from nowhere. Balance = work of the motor on what it moves, relative to the tissue, plus
// the rise of the model's stored energy as the device renders it, less what the device's own physical damping
// and friction took: section 4's inequality, summed. In a passive system it never rises; `rise_j` is the most
// that it rose above any earlier value, so no reserve hides it.
class EnergyBalance {
  public:
    void add(double motor_work_j, double stored_rise_j, double lost_j) {
        balance_j_ += motor_work_j + stored_rise_j - lost_j;
        lowest_j_ = balance_j_ < lowest_j_ ? balance_j_ : lowest_j_;
        rise_j_ = balance_j_ - lowest_j_ > rise_j_ ? balance_j_ - lowest_j_ : rise_j_;
    }
    double rise_j() const { return rise_j_; }

  private:
    double balance_j_ = 0.0, lowest_j_ = 0.0, rise_j_ = 0.0;
};

struct CaseResult {
    std::uint64_t ticks = 0;
    double forced_share = 0.0;  // of the ticks from rest on in which a force was sent
    std::uint32_t faults = 0;
    bool not_finite = false;
    double rise_j = 0.0, rise_limit_j = 0.0;
    Cycle cycle;
    // By sampling, delay and encoder: the motor gives more than the model's force on the same way would. A
    // body that rings on its own is not a limit cycle. In a window with an event nothing is judged: a cut or
    // a slip throws the tip about.
    bool cycle_is_fed = false, cycle_judged = true;
    double step_n = 0.0;  // the largest change of force beyond the model's springs without an event
    double bare_ratio = 0.0,
           held_ratio = 0.0;  // worst tangent over 2 b/T, b physical, without and with the hand

    bool energyFails() const { return rise_j > rise_limit_j; }
    bool cycles() const { return cycle.lasts && cycle_is_fed && cycle_judged; }
    bool stepFails() const { return step_n > kStep_n; }
    bool fails() const { return not_finite || energyFails() || cycles() || stepFails(); }
};

}  // namespace stylet::stress
