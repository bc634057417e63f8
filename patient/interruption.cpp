#include "patient/interruption.h"

#include <algorithm>
#include <cmath>

#include "patient/transcendental.h"

namespace stylet::patient {
namespace {

constexpr double kPi = 3.14159265358979323846;
// A gasp and three bursts, or one long rise; heights as shares of the amplitude.
constexpr double kGasp_s = 1.2, kBurst_s = 0.4, kBursts = 3.0, kGasp = 0.5, kBurst = 0.2;
constexpr double kSigh = 0.8, kSighPeriods = 1.4;

// A rise and a fall within `length_s` from t = 0 on, smooth to the third derivative at both ends.
Surrogate hump(double t_s, double length_s, double height_v) noexcept {
    if (!(t_s > 0.0 && t_s < length_s)) return {};
    const double angle = kPi * t_s / length_s, s = detSin(angle), c = detCos(angle);
    return {height_v * (s * s * s * s), 4.0 * kPi / length_s * height_v * (s * s * s * c)};
}

double lengthOf_s(InterruptionKind kind, const BreathPlan& plan) noexcept {
    return kind == InterruptionKind::cough ? kGasp_s + kBursts * kBurst_s
                                           : kSighPeriods * plan.rhythm.period_s;
}

}  // namespace

void interrupt(Interruption& s, BreathingState& breathing, const BreathPlan& plan,
               InterruptionKind kind) noexcept {
    if (kind == InterruptionKind::none || s.kind != InterruptionKind::none) return;
    if (breathing.held) {
        const bool recorded = !plan.recording_v.empty();
        breathing.limit_ticks = std::max<std::uint64_t>(1, breathing.held_ticks);  // spent with the next tick
        breathing.coughs_up = kind == InterruptionKind::cough && !recorded;
        if (!recorded) return;  // the breath that ends the hold is the cough or the sigh
    }
    s = {kind, 0};
}

void stepInterruption(Interruption& s, const BreathPlan& plan, double dt_s) noexcept {
    if (s.kind == InterruptionKind::none) return;
    if (double(++s.ticks) * dt_s >= lengthOf_s(s.kind, plan)) s = {};
}

Surrogate interruptionAt(const Interruption& s, const BreathPlan& plan, double dt_s) noexcept {
    const double t_s = double(s.ticks) * dt_s, a = plan.rhythm.amplitude;
    if (s.kind == InterruptionKind::none) return {};
    if (s.kind == InterruptionKind::sigh) return hump(t_s, lengthOf_s(s.kind, plan), kSigh * a);
    if (t_s <= kGasp_s) return hump(t_s, kGasp_s, kGasp * a);
    const double since_s = t_s - kGasp_s;
    return hump(since_s - kBurst_s * std::floor(since_s / kBurst_s), kBurst_s, kBurst * a);
}

}  // namespace stylet::patient
