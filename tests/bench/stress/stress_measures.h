// The limits that the campaign sets for a run. They are checked against the true state of the simulated
// device, at the motor and the tip, not against the controller's estimates.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/haptics.h"
#include "tests/support/simulated_device.h"

namespace stylet::stress {

// Limits, each with its reason.
inline constexpr double kStep_n = 0.145;  // noticeable force: the study's threshold
// A fingertip feels 10 to 30 um at 20 to 50 Hz. The limit adds 2.5 encoder counts of amplitude, 5 from peak
// to peak: an edge is lost at each reversal, and estimating a speed needs two more counts. Oscillations of up
// to 2.4 counts were observed whose size did not depend on the controller's gain (weak bare devices without
// friction, 0.02 N). Only the device's own friction can end an oscillation within the encoder's resolution
// (K <= 2 f_c / Delta).
inline constexpr double kCycle_m = 20e-6, kCycle_counts = 2.5;
// An oscillation is fed if it gains more energy than the device's own damping and friction take, by more than
// this share of its energy per second. Otherwise it decays, even if slowly.
inline constexpr double kFed_per_s = 0.2;
inline constexpr double kCycle_hz = 5.0;  // slower motion is the hand's own sway
inline constexpr double kCycleWindow_s =
    1.0;  // the end of a case, a second or more after the hand came to rest

// A sustained oscillation.
struct Cycle {
    double amplitude_m = 0.0, hz = 0.0;
    bool lasts = false;  // wider than the limit, faster than kCycle_hz, and not decaying
};
// Analyses an evenly sampled position. Removes motion slower than kCycle_hz first.
Cycle findCycle(const std::vector<double>& position_m, double dt_s, double wide_m = kCycle_m);

// Finds energy that the loop creates. Balance = work of the motor on the body, relative to the tissue, plus
// the rise of the model's stored energy as the device renders it, minus the energy lost in the device's own
// damping and friction: the inequality of model, section 4, summed. In a passive system it never rises.
// `rise_j` is the largest rise above any earlier value, so earlier losses cannot hide it.
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
    double forced_share = 0.0;  // share of the ticks since kRest_s in which a force was sent
    std::uint32_t faults = 0;
    bool not_finite = false;
    double rise_j = 0.0, rise_limit_j = 0.0;
    Cycle cycle;
    // Fed by sampling, delay and encoder: the motor does more work than the model's force would on the same
    // path. A body that rings on its own is not a limit cycle. A window with an event is not judged, because
    // a cut or a slip makes the tip jump.
    bool cycle_is_fed = false, cycle_judged = true;
    double step_n = 0.0;  // the largest change of force beyond the model's springs without an event
    double bare_ratio = 0.0,
           held_ratio = 0.0;  // worst tangent over 2 b/T, b = physical damping, without and with the hand

    bool energyFails() const { return rise_j > rise_limit_j; }
    bool cycles() const { return cycle.lasts && cycle_is_fed && cycle_judged; }
    bool stepFails() const { return step_n > kStep_n; }
    bool fails() const { return not_finite || energyFails() || cycles() || stepFails(); }
};

}  // namespace stylet::stress
