// The breath as a signal: the surrogate v(t) that drives the motion, counted in ticks.
// Regular, irregular (jitter, sighs, coughs) or recorded; held on command by a patient who need not comply.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/hash.h"

namespace stylet::patient {

// The surrogate at one instant. v = 0 at end-exhale, 1 at the model's end-inhale.
struct Surrogate {
    double v = 0.0;
    double rate_per_s = 0.0;  // dv/dt
    double creep_v =
        0.0;  // drift of a hold, added to v AFTER v is clamped to the model's range; < 0 = cranial
    friend bool operator==(const Surrogate&, const Surrogate&) = default;
};

// The patient's own rhythm: v = amplitude * cos^4(pi t / period), the exhale longer (Lujan et al. 1999); t
// counts from end-inhale, phase_ticks below from end-exhale.
struct BreathingSignal {
    double period_s = 4.0;
    double amplitude = 1.0;
    friend bool operator==(const BreathingSignal&, const BreathingSignal&) = default;
};

// What becomes of a commanded hold. The defaults are a patient who complies for as long as it is wanted.
struct HoldManner {
    double creep_v = 0.0;   // the diaphragm's drift while held, reached after creep_s, linear until then
    double creep_s = 24.0;  // 5.6 mm in 24 s are seen
    double missed = 0.0;    // share of end-exhales at which the command is not heeded, 0 to 1
    double level_v = 0.0;   // held at up to so much above end-exhale
    double limit_s = 0.0;   // breath lasts for so long, give or take a fifth; 0 = without end
    friend bool operator==(const HoldManner&, const HoldManner&) = default;
};

// How the patient breathes in an attempt. A sigh is a deep slow breath; a cough a quick one with three
// bursts on its way out, and it ends a hold.
struct BreathPlan {
    BreathingSignal rhythm{};
    double period_jitter = 0.0, depth_jitter = 0.0;  // standard deviation over mean; 0.05 to 0.15 in health
    double sighs = 0.0, coughs = 0.0;                // share of breaths
    HoldManner hold{};
    std::uint64_t seed = 0;
    // Recorded: v every recording_dt_s, a closed loop. Takes the place of the rhythm but for its amplitude,
    // and of jitter, sighs and coughs. Empty: none.
    std::vector<double> recording_v{};
    double recording_dt_s = 0.1;
    friend bool operator==(const BreathPlan&, const BreathPlan&) = default;
};

// Every number finite and within reason: what a file may hand to the functions below.
bool isPlayable(const BreathPlan&) noexcept;

// One breath: from start_v to peak_v and on to end_v, halves of equal length, C1 where breaths join.
struct OneBreath {
    std::uint64_t ticks = 0;  // 0: none has begun
    double start_v = 0.0, peak_v = 0.0, end_v = 0.0;
};

// Where in its breath the patient is. A commanded hold takes effect at the next end-exhale; the breath goes
// on from there when it ends. Counted in ticks, so no rounding accumulates.
struct BreathingState {
    std::uint64_t phase_ticks = 0;  // since end-exhale; of a recording since its begin
    std::uint64_t breath = 0;       // breaths begun, holds counted: the index of its draws
    OneBreath now;
    std::uint32_t bursts_left = 0;  // of a cough
    bool hold_wanted = false;
    bool held = false;
    bool at_end_exhale = true;
    bool gave_up = false;    // breathes on although a hold is wanted, until it is commanded anew
    bool coughs_up = false;  // the present hold will end in a cough
    std::uint64_t held_ticks = 0, limit_ticks = 0;
    double eased_v = 0.0;  // creep left by the last hold, easing off; or where the present one began
    std::uint64_t eased_ticks = 0;
};

// Haptics thread. noexcept, no allocation.
void commandHold(BreathingState&, bool wanted) noexcept;
void stepBreathing(BreathingState&, const BreathPlan&, double dt_s) noexcept;  // one tick
Surrogate surrogateAt(const BreathingState&, const BreathPlan&, double dt_s) noexcept;

// The longest that a patient who heeds it lets a command wait: no breath and no coughing lasts longer.
double longestBreath_s(const BreathPlan&, double dt_s);

void hashSurrogate(StateHash&, const Surrogate&) noexcept;
void hashBreathing(StateHash&, const BreathingState&) noexcept;
void hashPlan(StateHash&, const BreathPlan&) noexcept;

}  // namespace stylet::patient
