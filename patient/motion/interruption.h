// A cough or a sigh on demand. It is added to the breath at once, at any phase, and starts and ends at
// zero.
// Hashed with the attempt: double precision, no libm transcendentals.
#pragma once

#include "patient/motion/signal.h"

namespace stylet::patient {

enum class InterruptionKind : std::uint8_t { none, cough, sigh };

struct Interruption {
    InterruptionKind kind = InterruptionKind::none;
    std::uint64_t ticks = 0;  // since the start
};

// All below: haptics thread. noexcept, no allocation.
// interrupt() starts a cough or sigh. It is ignored while another one is active. During a breath-hold this
// cough or sigh ends the hold, as a spontaneous one would.
void interrupt(Interruption&, BreathingState&, const BreathPlan&, InterruptionKind) noexcept;
void stepInterruption(Interruption&, const BreathPlan&, double dt_s) noexcept;  // one tick
// The surrogate to add to that of the breath: v and its rate.
Surrogate interruptionAt(const Interruption&, const BreathPlan&, double dt_s) noexcept;

}  // namespace stylet::patient
