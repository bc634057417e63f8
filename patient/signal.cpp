// Based on Lujan et al. 1999. Hashed: double precision, no libm transcendental.
#include "patient/signal.h"

#include <cmath>

#include "patient/transcendental.h"

namespace stylet::patient {
namespace {

constexpr double kPi = 3.14159265358979323846;

std::uint64_t periodTicks(const BreathingSignal& signal, double dt_s) noexcept {
    const double ticks = std::floor(signal.period_s / dt_s + 0.5);
    return ticks >= 1.0 && ticks < 1e15 ? std::uint64_t(ticks) : 1;
}

}  // namespace

void stepBreathing(BreathingState& state, const BreathingSignal& signal, double dt_s) noexcept {
    state.held = state.hold_wanted && state.phase_ticks == 0;
    if (state.held) return;
    if (++state.phase_ticks >= periodTicks(signal, dt_s)) state.phase_ticks = 0;
    state.held = state.hold_wanted && state.phase_ticks == 0;
}

Surrogate surrogateAt(const BreathingState& state, const BreathingSignal& signal, double dt_s) noexcept {
    const double period = double(periodTicks(signal, dt_s));
    const double angle = kPi * double(state.phase_ticks) / period;
    const double s = detSin(angle), c = detCos(angle);
    // sin^4 is cos^4 with end-exhale at phase 0.
    return {signal.amplitude * s * s * s * s,
            state.held ? 0.0 : 4.0 * kPi / (period * dt_s) * signal.amplitude * s * s * s * c};
}

}  // namespace stylet::patient
