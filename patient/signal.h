// The breath as a signal: the surrogate v(t) that drives the motion, counted in ticks.
#pragma once

#include <cstdint>

namespace stylet::patient {

// The surrogate at one instant. v = 0 at end-exhale, 1 at the model's end-inhale.
struct Surrogate {
    double v = 0.0;
    double rate_per_s = 0.0;  // dv/dt
    double creep_v =
        0.0;  // drift of a hold, added to v AFTER v is clamped to the model's range; < 0 = cranial
    friend bool operator==(const Surrogate&, const Surrogate&) = default;
};

// A regular signal v = amplitude * cos^4(pi t / period), the exhale longer (Lujan et al. 1999); t counts from
// end-inhale, phase_ticks below from end-exhale.
struct BreathingSignal {
    double period_s = 4.0;
    double amplitude = 1.0;
    friend bool operator==(const BreathingSignal&, const BreathingSignal&) = default;
};

// Where in its breath the patient is. A commanded hold takes effect at the next end-exhale; the breath goes
// on from there when it ends. Counted in ticks, so no rounding accumulates.
struct BreathingState {
    std::uint64_t phase_ticks = 0;  // since end-exhale
    bool hold_wanted = false;
    bool held = false;
};

// Haptics thread. noexcept, no allocation. One tick of dt_s.
void stepBreathing(BreathingState&, const BreathingSignal&, double dt_s) noexcept;
Surrogate surrogateAt(const BreathingState&, const BreathingSignal&, double dt_s) noexcept;

}  // namespace stylet::patient
