#include "patient/motion/interruption.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/transcendental.h"

namespace stylet::patient {
namespace {

// A cough is a gasp and three bursts; a sigh is one long rise. Heights are shares of the amplitude.
constexpr double kPlayedGasp_s = 1.2, kPlayedBurst_s = 0.4, kPlayedBursts = 3.0, kGasp = 0.5, kBurst = 0.2;
constexpr double kSigh = 0.8, kSighPeriods = 1.4;

// Rises and falls within `length_s` from t = 0. Value and first three derivatives are zero at both ends.
Surrogate hump(double t_s, double length_s, double height_v) noexcept {
    if (!(t_s > 0.0 && t_s < length_s)) return {};
    const double angle = std::numbers::pi * t_s / length_s, s = detSin(angle), c = detCos(angle);
    return {height_v * (s * s * s * s), 4.0 * std::numbers::pi / length_s * height_v * (s * s * s * c)};
}

double duration_s(InterruptionKind kind, const BreathPlan& plan) noexcept {
    return kind == InterruptionKind::cough ? kPlayedGasp_s + kPlayedBursts * kPlayedBurst_s
                                           : kSighPeriods * plan.rhythm.period_s;
}

}  // namespace

void interrupt(Interruption& s, BreathingState& breathing, const BreathPlan& plan,
               InterruptionKind kind) noexcept {
    if (kind == InterruptionKind::none || s.kind != InterruptionKind::none) return;
    if (breathing.held) {
        const bool recorded = !plan.recording_v.empty();
        // ends the hold at the next tick
        breathing.limit_ticks = std::max<std::uint64_t>(1, breathing.held_ticks);
        breathing.ends_in_cough = kind == InterruptionKind::cough && !recorded;
        if (!recorded) return;  // the breath that ends the hold is the cough or the sigh
    }
    s = {kind, 0};
}

void stepInterruption(Interruption& s, const BreathPlan& plan, double dt_s) noexcept {
    if (s.kind == InterruptionKind::none) return;
    if (double(++s.ticks) * dt_s >= duration_s(s.kind, plan)) s = {};
}

Surrogate interruptionAt(const Interruption& s, const BreathPlan& plan, double dt_s) noexcept {
    const double t_s = double(s.ticks) * dt_s, a = plan.rhythm.amplitude;
    if (s.kind == InterruptionKind::none) return {};
    if (s.kind == InterruptionKind::sigh) return hump(t_s, duration_s(s.kind, plan), kSigh * a);
    if (t_s <= kPlayedGasp_s) return hump(t_s, kPlayedGasp_s, kGasp * a);
    const double since_s = t_s - kPlayedGasp_s;
    return hump(since_s - kPlayedBurst_s * std::floor(since_s / kPlayedBurst_s), kPlayedBurst_s, kBurst * a);
}

}  // namespace stylet::patient
