// A cough or a sigh on demand: laid over the breath at once, from rest to rest, whatever the breath is at.
// Hashed with the attempt; double precision, no libm transcendental.
#pragma once

#include "patient/signal.h"

namespace stylet::patient {

enum class InterruptionKind : std::uint8_t { none, cough, sigh };

struct Interruption {
    InterruptionKind kind = InterruptionKind::none;
    std::uint64_t ticks = 0;  // since it began
};

// All below: haptics thread. noexcept, no allocation.
// Begins one; another while one lasts changes nothing. A held breath ends in it instead, as it does by
// itself.
void interrupt(Interruption&, BreathingState&, const BreathPlan&, InterruptionKind) noexcept;
void stepInterruption(Interruption&, const BreathPlan&, double dt_s) noexcept;  // one tick
// What it adds to v and its rate.
Surrogate interruptionAt(const Interruption&, const BreathPlan&, double dt_s) noexcept;

}  // namespace stylet::patient
