// Keeps what the hand feels from giving back more energy than it was given.
// Based on Hannaford and Ryu, "Time-Domain Passivity Control of Haptic Interfaces", IEEE Trans. Robotics and
// Automation 18(1), 2002, with two changes (model, section 4). The observer works on motion RELATIVE to the
// tissue and against the energy S in the model's springs, so that the breath may push a hand that rests. And
// it keeps no reserve: what friction took in one tick does not pay for the next, only debts are carried.
//
// A spring K held over a tick T while the tip moves dx gives K dx^2 / 2 too much; the controller's answer is
// then K dx / 2, the force half a tick ahead: the damping K T / 2 of Colgate and Schenkel's condition.
//
// An encoder tells a slow motion late and all at once. What it tells after n still ticks is taken to have
// happened evenly over them: under the forces of all of them, owing a nth of what one tick's motion would;
// and the answer is spread over the n ticks until the next count is due. Otherwise a count would owe n times
// too much, and the answer to it would be a kick. The first count back after still ticks is the same edge
// crossed again: no way at all.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/realtime.h"
#include "patient/hash.h"

namespace stylet::haptics {

using patient::Vec3;

// So much more is asked back than was seen: jitter is not seen, and of a slow swing over few counts only
// about half (the edges where it turns).
inline constexpr double kMargin = 1.25, kSlowMargin = 2.5;
// Longest delay of a device that is accounted for.
inline constexpr int kMaxDelayTicks = 16;
// A count after so many still ticks, and any later one, is spread over so many.
inline constexpr int kMaxSpreadTicks = 48;

// What a device was told in one tick: all of it, and the wall's part. The scales say what share of the
// model's force (gain and ramp) and of the wall's that is: their springs are scaled alike. A ramp that goes
// on scales the springs, not the hand's account: only motion counts.
struct SentForce {
    Vec3 force_n{0.0}, wall_n{0.0};
    double scale = 0.0, wall_scale = 0.0;
    Vec3 controller_n{0.0};  // the controller's part of it
};

// What one tick brought. Vectors in one frame, any.
struct Motion {
    Vec3 tip_moved_m{0.0}, tissue_moved_m{0.0};
    Vec3 model_n{0.0};           // the model's force, unscaled
    double energy_j = 0.0;       // S, unscaled
    double wall_energy_j = 0.0;  // unscaled
    bool event = false;          // the springs are no longer those of the last tick
};

struct PassivityState {
    std::array<SentForce, kMaxDelayTicks + kMaxSpreadTicks> sent{};  // a ring
    std::uint32_t newest = 0;
    Vec3 model_n{0.0};  // of the last tick
    double energy_j = 0.0, wall_energy_j = 0.0;
    double shortfall_j = 0.0;  // what was given too much and is not yet taken back
    // Each axis of the tip: the last motion, the ticks it is spread over, the ticks since.
    Vec3 told_m{0.0};
    std::array<std::uint32_t, 3> spread{1, 1, 1}, still{};
    std::array<std::int32_t, 3> sense{};  // which way the last count went
};

// All: haptics thread, noexcept, no allocation, in this order each tick.
// The observer. The force of `delay_ticks` ago, at most kMaxDelayTicks, acted on this motion.
void observe(PassivityState&, const Motion&, int delay_ticks) noexcept STYLET_NONBLOCKING;
// The controller: the force that takes the shortfall back if the tip goes on as it went, with at most
// `most_n_per_m` times that way.
Vec3 takeBack(const PassivityState&, const Motion&, int delay_ticks,
              double most_n_per_m) noexcept STYLET_NONBLOCKING;
void remember(PassivityState&, const SentForce&) noexcept STYLET_NONBLOCKING;
void hashPassivity(patient::StateHash&, const PassivityState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
