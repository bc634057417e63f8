#include "haptics/output/output.h"

#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

namespace {

// Shortens v to at most `limit`.
Vec3 clampLength(const Vec3& v, double limit, bool& limited) noexcept {
    const double length = glm::length(v);
    if (length <= limit) return v;
    limited = true;
    return v * (limit / length);
}

// Moves the model force toward `wanted_n` by at most `step_n`.
void limitRate(OutputState& s, const Vec3& wanted_n, double step_n) noexcept {
    bool cut = false;
    const Vec3 change = clampLength(wanted_n - s.model_n, step_n, cut);
    s.model_n = cut ? s.model_n + change : wanted_n;
    s.limited = s.limited || cut;
}

// Upper bound of the controller's slope, N per m of motion per tick. First bound: twice the negative
// damping of the stiffest spring, K (T/2 + t_d) (Colgate and Schenkel), over T. Second bound, from the mass
// of the bare mechanism: a quarter of the slope that stops the motion in one tick, so stopping takes at least
// four ticks.
double maxControllerSlope(const DeviceProfile& profile, double tangent_n_per_m, int delay_ticks,
                          double dt_s) noexcept {
    const double by_mass =
        0.25 * valueOrDefault(profile.mass_kg, kLightestMass_kg) / (dt_s * dt_s * (1.0 + delay_ticks));
    return std::min(by_mass, 2.0 * tangent_n_per_m * (0.5 + delay_ticks));
}

// The controller's force changes per tick by less than a hand can notice (0.145 N, the study's threshold).
constexpr double kControllerStep_n = 0.1;

// Rounded up: energy created during an ignored delay would not be observed.
int delayTicks(const DeviceProfile& profile, double dt_s) noexcept {
    const double ticks = std::ceil(valueOrDefault(profile.delay_s, 0.0) / dt_s - 1e-9);
    return int(std::clamp(ticks, 0.0, double(kMaxDelayTicks)));
}

// Motion and energy of this tick. If the model's values are not finite, its springs count as unchanged.
Motion computeMotion(const OutputState& s, const OutputTick& tick, const Vec3& modelled_n,
                     bool finite) noexcept {
    Motion motion;
    motion.model_n = modelled_n;
    motion.energy_j = s.passivity.energy_j;
    if (s.moved) motion.tip_moved_m = tick.grip_m - s.grip_m;
    if (finite) {
        motion.tissue_moved_m = tick.tool.tissue_moved_m;
        motion.energy_j = tick.tool.energy_j;
        motion.event = tick.tool.event;
    }
    return motion;
}

}  // namespace

double maxTangent(const patient::TissueTable& table, const NeedleSettings& needle) noexcept {
    double worst = 0.0;
    for (const patient::TissueRow& row : table)
        worst = std::max(worst, (isRigid(row) ? 1.0 : 2.0 - needle.a1_share) * row.stiffness_n_per_m);
    return worst;
}

double outputGain(const DeviceProfile& profile, const OutputSettings& settings) noexcept {
    const double stiffness = valueOrDefault(profile.stiffness_n_per_m, kWeakestStiffness_n_per_m);
    const double force = valueOrDefault(profile.force_peak_n, kWeakestForce_n);
    return std::min({1.0, stiffness / settings.model_tangent_n_per_m, force / settings.model_force_n});
}

Vec3 stepOutput(OutputState& s, const OutputSettings& settings, const DeviceProfile& profile, double gain,
                const OutputTick& tick, double dt_s) noexcept {
    s.limited = false;
    const ToolForce& tool = tick.tool;
    const bool finite =
        isFinite(tool.force_n) && isFinite(tool.tissue_moved_m) && std::isfinite(tool.energy_j);
    if (finite) limitRate(s, tool.force_n, settings.rate_limit_n_per_s * dt_s);
    const Vec3 modelled = clampLength(s.model_n, settings.model_force_n, s.limited);

    // The clutch scales the energy of the springs as it scales their force.
    const double scale = gain * tick.share;
    const WallForce wall = workspaceWall(profile, tick.grip_m);
    const double peak_n = valueOrDefault(profile.force_peak_n, kWeakestForce_n);
    const Vec3 at_full = clampLength(scale * modelled + wall.force_n, peak_n, s.limited);
    // The check at the start must see contact even while the clutch is pressed.
    const Vec3 unclutched = gain * modelled + wall.force_n;
    const std::uint32_t fault_bits = tick.fault_bits | (finite ? 0u : std::uint32_t(kFaultBadForce));
    const double last_level = s.safety.level;
    if (peak_n > 0.0) {
        stepSafety(s.safety, fault_bits, glm::length(unclutched), glm::length(wall.force_n), dt_s);
    } else {
        reportWithoutForce(s.safety, fault_bits);
    }
    const double level = s.safety.level;

    Motion motion = computeMotion(s, tick, modelled, finite);
    motion.wall_energy_j = wall.energy_j;
    s.grip_m = tick.grip_m;
    s.share = tick.share;
    s.moved = true;
    const int delay = delayTicks(profile, dt_s);
    observe(s.passivity, motion, delay);
    if (level * tick.share == 0.0) s.passivity.excess_energy_j = 0.0;
    const double tangent_n_per_m = gain * settings.model_tangent_n_per_m;
    const Vec3 answer =
        settings.controller_share * tick.share *
        dissipate(s.passivity, motion, delay, maxControllerSlope(profile, tangent_n_per_m, delay, dt_s));
    bool smoothed = false;
    s.controller_n += clampLength(answer - s.controller_n, kControllerStep_n, smoothed);

    // While a fault fades the force, its length stays within that of the last force, scaled to zero, even if
    // the model's force rises.
    const bool fades = s.safety.stage == ForceStage::fading && last_level > 0.0;
    const double most_n = fades ? glm::length(s.sent_n) / last_level : peak_n;
    s.sent_n = clampLength(level * at_full + s.controller_n, level * std::min(most_n, peak_n), s.limited);
    // What the fade takes away is not the controller's answer. Stored as such, it would go on after the fade.
    const Vec3 controller_n = s.sent_n - level * at_full;
    if (!fades) s.controller_n = controller_n;
    recordSentForce(s.passivity, {s.sent_n, level * wall.force_n, level * scale, level, controller_n});
    return s.sent_n;
}

void hashOutput(StateHash& hash, const OutputState& s) noexcept {
    hashSafety(hash, s.safety);
    hashPassivity(hash, s.passivity);
    hash.add(s.model_n, s.grip_m, s.controller_n, s.sent_n);
    hash.add(std::uint64_t(s.moved) | std::uint64_t(s.limited) << 1);
}

}  // namespace stylet::haptics
