#include "haptics/tools/guide.h"

#include <algorithm>
#include <cmath>

#include "base/smoothstep.h"

namespace stylet::haptics {

namespace {

// Beyond the rail's ends the force on a free needle fades out over this distance, so that it does not start
// abruptly.
constexpr double kFade_m = 0.010;

// Energy needed to move the needle from the line out of the rail's reach.
double crestEnergy(const GuideSettings& s) noexcept {
    return 0.5 * s.stiffness_n_per_m * s.catch_m * std::max(s.catch_m, s.reach_m);
}

// Force toward the line at distance `r_m`, and the energy there relative to a needle far away. A free needle
// and a snapped one have the same potential within the catch distance, so snapping in adds no energy.
struct Detent {
    double force_n = 0.0, energy_j = 0.0;
};

Detent snappedDetent(const GuideSettings& s, double r_m) noexcept {
    const double k = s.stiffness_n_per_m;
    return {k * r_m, 0.5 * k * r_m * r_m - crestEnergy(s)};
}

Detent freeDetent(const GuideSettings& s, double r_m) noexcept {
    const double c = s.catch_m, fall_m = s.reach_m - c;
    if (r_m <= c) return snappedDetent(s, r_m);
    if (r_m >= s.reach_m) return {};
    const double left = (s.reach_m - r_m) / fall_m, crest_n = s.stiffness_n_per_m * c;
    return {crest_n * left, -0.5 * crest_n * fall_m * left * left};
}

// 1 along the rail, 0 from kFade_m beyond its ends. Continuous first derivative.
struct Fade {
    double share = 0.0, slope_per_m = 0.0;
};

Fade fadeAt(const GuideSettings& s, double height_m) noexcept {
    const double beyond_m = std::max(-height_m, height_m - s.length_m);
    if (beyond_m <= 0.0) return {1.0, 0.0};
    if (beyond_m >= kFade_m) return {};
    const double t = 1.0 - beyond_m / kFade_m;
    return {smoothStep(t), std::copysign(6.0 * t * (1.0 - t) / kFade_m, s.length_m - 2.0 * height_m)};
}

}  // namespace

GuideResult stepGuide(GuideState& state, const GuideSettings& s, const Pose& patient_from_guide,
                      const Pose& patient_from_stylus, bool free) noexcept {
    const Vec3 rail = patient_from_guide.direction(Vec3(0.0, 0.0, 1.0));
    const Vec3 shaft = patient_from_stylus.direction(Vec3(0.0, 0.0, 1.0));
    const Vec3 from_mouth = patient_from_stylus.position_m - patient_from_guide.position_m;
    const double height_m = glm::dot(from_mouth, rail);
    const Vec3 across = from_mouth - height_m * rail;
    const double r_m = glm::length(across);

    GuideResult out{patient_from_stylus};
    const bool at_rail = height_m >= 0.0 && height_m <= s.length_m;
    if (state.snapped) {
        const bool torn = free && s.stiffness_n_per_m * r_m > s.release_n;
        out.event = torn || height_m > s.length_m;
    } else {
        out.event = free && at_rail && r_m <= s.catch_m && glm::dot(rail, shaft) >= s.catch_cosine;
    }
    if (out.event) state.snapped = !state.snapped;

    Detent detent;
    double along_n = 0.0;
    if (state.snapped) {
        out.patient_from_needle = {patient_from_guide.rotation,
                                   patient_from_guide.position_m + height_m * rail};
        detent = snappedDetent(s, r_m);
    } else {
        const Detent whole = freeDetent(s, r_m);
        const Fade fade = fadeAt(s, height_m);
        const bool felt = whole.energy_j * fade.share < 0.0;
        out.event = out.event || (felt && free != state.free);
        if (free) {
            detent = {fade.share * whole.force_n, fade.share * whole.energy_j};
            along_n = -fade.slope_per_m * whole.energy_j;
        }
    }
    state.free = free;
    out.energy_j = detent.energy_j;
    out.force_n = along_n * rail;
    if (r_m > 0.0) out.force_n -= (detent.force_n / r_m) * across;
    return out;
}

}  // namespace stylet::haptics
