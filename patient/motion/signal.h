// The breathing signal: the surrogate v(t) that drives the motion, counted in ticks.
// It is regular, irregular (jitter, sighs, coughs) or recorded. The patient can hold the breath on command
// but may fail to comply.
#pragma once

#include <cstdint>
#include <vector>

#include "base/hash.h"

namespace stylet::patient {

// The surrogate at one instant. v = 0 at end-exhale, 1 at the model's end-inhale.
struct Surrogate {
    double v = 0.0;
    double rate_per_s = 0.0;  // dv/dt
    double creep_v = 0.0;     // drift during a hold, added AFTER v is clamped to its range; < 0 = cranial
    friend bool operator==(const Surrogate&, const Surrogate&) = default;
};

// The patient's own rhythm: v = amplitude * cos^4(pi t / period), with a longer exhale (Lujan et al.
// 1999). Here t counts from end-inhale; phase_ticks below counts from end-exhale.
struct BreathingSignal {
    double period_s = 4.0;
    double amplitude = 1.0;
    friend bool operator==(const BreathingSignal&, const BreathingSignal&) = default;
};

// How the patient follows a breath-hold command. By default the patient holds for as long as commanded.
struct HoldBehaviour {
    double creep_v = 0.0;   // drift of the diaphragm during a hold: linear until creep_s, then constant
    double creep_s = 24.0;  // 5.6 mm in 24 s have been observed
    double missed = 0.0;    // probability of missing the command at an end-exhale, 0 to 1
    double level_v = 0.0;   // the patient may hold up to this much above end-exhale
    double limit_s = 0.0;   // duration until the patient gives up, +- 20 %; 0: unlimited
    friend bool operator==(const HoldBehaviour&, const HoldBehaviour&) = default;
};

// How the patient breathes in an attempt. A sigh is a deep, slow breath. A cough is a quick breath with
// three bursts during exhalation; it ends a hold.
struct BreathPlan {
    BreathingSignal rhythm{};
    double period_jitter = 0.0, depth_jitter = 0.0;  // standard deviation over mean; 0.05 to 0.15 in health
    double sighs = 0.0, coughs = 0.0;                // share of breaths
    HoldBehaviour hold{};
    std::uint64_t seed = 0;
    // Recording: v every recording_dt_s, a closed loop. Replaces the rhythm (except its amplitude),
    // jitter, sighs and coughs. Empty: no recording.
    std::vector<double> recording_v{};
    double recording_dt_s = 0.1;
    friend bool operator==(const BreathPlan&, const BreathPlan&) = default;
};

// True if every number is finite and within the range that the functions below support. Check plans read
// from a file with it.
bool isValidPlan(const BreathPlan&) noexcept;

// One breath: from start_v to peak_v to end_v, in two halves of equal length. Joins its neighbours with C1
// continuity.
struct OneBreath {
    std::uint64_t ticks = 0;  // 0: no breath has begun
    double start_v = 0.0, peak_v = 0.0, end_v = 0.0;
};

// State of the breathing. A commanded hold begins at the next end-exhale; when it ends, the breath
// continues from there. Time is counted in ticks, so rounding errors do not accumulate.
struct BreathingState {
    std::uint64_t phase_ticks = 0;  // since end-exhale; for a recording, since its start
    std::uint64_t breath = 0;       // number of breaths begun; index of the random draws
    OneBreath now;
    std::uint32_t bursts_left = 0;  // remaining bursts of a cough
    bool hold_wanted = false;
    bool held = false;
    bool at_end_exhale = true;
    bool hold_aborted = false;   // the patient breathes although a hold is commanded, until the next command
    bool ends_in_cough = false;  // the current hold will end in a cough
    std::uint64_t held_ticks = 0, limit_ticks = 0;
    // creep that remains of the last hold and fades out; during a hold, the creep at its start
    double residual_creep_v = 0.0;
    std::uint64_t residual_creep_ticks = 0;
};

// Haptics thread. noexcept, no allocation.
void commandHold(BreathingState&, bool wanted) noexcept;
void stepBreathing(BreathingState&, const BreathPlan&, double dt_s) noexcept;  // one tick
Surrogate surrogateAt(const BreathingState&, const BreathPlan&, double dt_s) noexcept;

// Longest time until a compliant patient holds after a command: the longest breath, including coughs.
double longestBreath_s(const BreathPlan&, double dt_s);

void hashSurrogate(StateHash&, const Surrogate&) noexcept;
void hashBreathing(StateHash&, const BreathingState&) noexcept;
void hashPlan(StateHash&, const BreathPlan&) noexcept;

}  // namespace stylet::patient
