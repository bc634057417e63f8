// The limits that the campaign sets for a run. They are checked against the true state of the simulated
// device, at the motor and the tip, not against the controller's estimates.
#pragma once

#include <cstdint>
#include <vector>

#include "haptics/haptics.h"
#include "tests/support/simulated_device.h"

namespace stylet::stress {

// Limits, each with its reason.
inline constexpr double kStep_n = 0.145;  // smallest noticeable force (model.md, section 9)
// Limit of an oscillation's amplitude: kCycle_m plus kCycle_counts encoder counts. A fingertip feels 10 to 30
// um at 20 to 50 Hz. The counts are added because the controller cannot see an oscillation that small: the
// encoder loses an edge at each reversal, and estimating a speed needs two more counts. On weak bare devices
// without friction (0.02 N) there were oscillations of up to 2.4 counts. Their size did not depend on the
// controller's gain. Only the device's own friction can end such an oscillation. With stiffness K, Coulomb
// friction f_c and encoder count Delta, it does so if K <= 2 f_c / Delta.
inline constexpr double kCycle_m = 20e-6, kCycle_counts = 2.5;
// The loop feeds an oscillation if it adds more energy than the device's own damping and friction dissipate,
// and if it adds more per second than this share of the oscillation's energy. Less does not count.
inline constexpr double kFed_per_s = 0.2;
inline constexpr double kCycle_hz = 5.0;       // slower motion is the hand's own sway
inline constexpr double kCycleWindow_s = 1.0;  // the last second of a case; the hand rests from kRest_s on

// A sustained oscillation.
struct Cycle {
    double amplitude_m = 0.0, hz = 0.0;
    bool lasts = false;  // wider than the limit, faster than kCycle_hz, and not decaying
};
// Analyses an evenly sampled position. Removes motion slower than kCycle_hz first.
Cycle findCycle(const std::vector<double>& position_m, double dt_s, double wide_m = kCycle_m);

// Finds energy that the loop creates. The balance adds up the terms of the passivity condition
// (packaging/guide/model.md, section 4): the motor's work on the body, relative to the tissue, plus the rise
// of the model's stored energy (times the output gain), minus the energy that the device's own damping and
// friction dissipate. In a passive system it never rises. `rise_j` is the largest rise above any earlier
// value, so earlier losses cannot hide it.
class EnergyBalance {
  public:
    void add(double motor_work_j, double stored_rise_j, double dissipated_j) {
        balance_j_ += motor_work_j + stored_rise_j - dissipated_j;
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
    // cycle_is_fed: sampling, delay and encoder make the motor do more work than the model's force would do
    // on the same path, and by more than the device dissipates and kFed_per_s allows. A device that only
    // rings, and is not fed, does not fail. cycle_judged: false for a window with an event, because a cut or
    // a slip makes the tip jump.
    bool cycle_is_fed = false, cycle_judged = true;
    double step_n = 0.0;  // largest change of force without an event, minus what the springs explain
    // Steepest stiffness divided by 2 b / T (damping b, tick T), without and with the hand's damping. A ratio
    // above 1 is beyond the stability bound.
    double bare_ratio = 0.0, held_ratio = 0.0;

    bool energyFails() const { return rise_j > rise_limit_j; }
    bool cycles() const { return cycle.lasts && cycle_is_fed && cycle_judged; }
    bool stepFails() const { return step_n > kStep_n; }
    bool fails() const { return not_finite || energyFails() || cycles() || stepFails(); }
};

}  // namespace stylet::stress
