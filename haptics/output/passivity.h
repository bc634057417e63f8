// Prevents the rendered force from returning more energy to the hand than the hand has put in.
// Based on Hannaford and Ryu, "Time-Domain Passivity Control of Haptic Interfaces", IEEE Trans. Robotics and
// Automation 18(1), 2002, with two changes (model, section 4). First, the observer uses motion RELATIVE to
// the tissue and the energy S stored in the model's springs, so that breathing may push a resting hand.
// Second, it keeps no reserve: energy dissipated by friction in one tick does not offset an excess in the
// next. Only deficits are carried over.
//
// If the force of a spring K is held over a tick T while the tip moves by dx, the hand receives K dx^2 / 2
// too much. The controller then adds K dx / 2 against the motion, which gives the spring's force half a tick
// ahead. That equals the damping K T / 2 of Colgate and Schenkel's condition.
//
// An encoder reports a slow motion late, one count at a time. A count reported after n still ticks is
// assumed to have happened evenly over them. Its work is computed with the forces of all n ticks. Its energy
// error is 1/n of that of the same motion in one tick. The controller's force is spread over the n ticks
// until the next count is due. Without this the error would be overestimated n times, and the controller
// would kick. The first count after a change of direction is the same encoder edge crossed again and counts
// as no motion, unless the tip moved in the other direction in each of the last two ticks: then the encoder
// is fine enough to show the turn.
#pragma once

#include <array>
#include <cstdint>

#include "base/hash.h"
#include "base/realtime.h"

namespace stylet::haptics {

// Factors by which the controller dissipates more than the observed excess. Jitter is not observed. Of a slow
// oscillation over a few counts only about half is observed, because the counts at its turning points are
// ignored. More than 3 would drag at a slow hand. Even so a frictionless device with a delay of two ticks may
// keep an oscillation of a few counts (tests/bench/stress).
inline constexpr double kMargin = 1.25, kSlowMargin = 3.0;
// Longest device delay that is taken into account.
inline constexpr int kMaxDelayTicks = 16;
// Longest spread. A count after this many still ticks or more is spread over this many ticks.
inline constexpr int kMaxSpreadTicks = 48;

// The force sent in one tick: the total, and the wall's part. `scale` is the factor on the model's force
// (gain, clutch, ramp), `wall_scale` the factor on the wall's. The spring energies are scaled by the same
// factors. A ramp changes the springs' scale without any work by the hand, so only motion is counted.
struct SentForce {
    Vec3 force_n{0.0}, wall_n{0.0};
    double scale = 0.0, wall_scale = 0.0;
    Vec3 controller_n{0.0};  // the controller's part of it
};

// Motion and energy of one tick. All vectors are in the same frame; any frame will do.
struct Motion {
    Vec3 tip_moved_m{0.0}, tissue_moved_m{0.0};
    Vec3 model_n{0.0};           // the model's force, unscaled
    double energy_j = 0.0;       // S, unscaled
    double wall_energy_j = 0.0;  // unscaled
    bool event = false;          // the springs differ from those of the last tick
};

struct PassivityState {
    std::array<SentForce, kMaxDelayTicks + kMaxSpreadTicks> sent{};  // ring buffer
    std::uint32_t newest = 0;
    Vec3 model_n{0.0};  // of the last tick
    double energy_j = 0.0, wall_energy_j = 0.0;
    double excess_energy_j = 0.0;  // energy given to the hand in excess and not yet dissipated
    // Per axis of the tip: the last motion, the number of ticks it is spread over, the ticks since.
    Vec3 reported_motion_m{0.0};
    std::array<std::uint32_t, 3> spread{1, 1, 1}, still{};
    std::array<std::int32_t, 3> sense{};  // direction of the last count
    std::array<bool, 3> steady{};         // the last two ticks had counts in the same direction
};

// All functions: haptics thread, noexcept, no allocation, called in this order in each tick.
// The observer. The force sent `delay_ticks` ago (at most kMaxDelayTicks) acted on this motion.
void observe(PassivityState&, const Motion&, int delay_ticks) noexcept STYLET_NONBLOCKING;
// The controller. Returns the force that dissipates the excess if the tip keeps its current motion. Its
// magnitude is at most `max_n_per_m` times that motion per tick.
Vec3 dissipate(const PassivityState&, const Motion&, int delay_ticks,
               double max_n_per_m) noexcept STYLET_NONBLOCKING;
void recordSentForce(PassivityState&, const SentForce&) noexcept STYLET_NONBLOCKING;
void hashPassivity(StateHash&, const PassivityState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
