#include "haptics/guide.h"

#include <cmath>

namespace stylet::haptics {

namespace {

// Force toward the line at `r_m` beside it, and the work done to get there. The potential is the same for a
// free needle and a snapped one within the catch, so snapping in adds no energy.
struct Detent {
    double force_n = 0.0, energy_j = 0.0;
};

Detent freeDetent(const GuideSettings& s, double r_m) noexcept {
    const double k = s.stiffness_n_per_m, c = s.catch_m;
    if (r_m <= c) return {k * r_m, 0.5 * k * r_m * r_m};
    const double fall_m = s.reach_m - c;
    if (fall_m <= 0.0) return {0.0, 0.5 * k * c * c};
    const double past_m = (r_m < s.reach_m ? r_m : s.reach_m) - c;
    const double left = 1.0 - past_m / fall_m;
    return {k * c * left, 0.5 * k * c * c + 0.5 * k * c * past_m * (1.0 + left)};
}

}  // namespace

Guided stepGuide(GuideState& state, const GuideSettings& s, const Pose& patient_from_guide,
                 const Pose& patient_from_stylus, bool free) noexcept {
    const Vec3 rail = patient_from_guide.direction(Vec3(0.0, 0.0, 1.0));
    const Vec3 shaft = patient_from_stylus.direction(Vec3(0.0, 0.0, 1.0));
    const Vec3 from_mouth = patient_from_stylus.position_m - patient_from_guide.position_m;
    const double height_m = glm::dot(from_mouth, rail);
    const Vec3 across = from_mouth - height_m * rail;
    const double r_m = std::sqrt(glm::dot(across, across));

    Guided out{patient_from_stylus};
    const bool at_rail = height_m >= 0.0 && height_m <= s.length_m;
    if (state.snapped) {
        const bool torn = free && s.stiffness_n_per_m * r_m > s.release_n;
        out.event = torn || height_m > s.length_m;
    } else {
        out.event = free && at_rail && r_m <= s.catch_m && glm::dot(rail, shaft) >= s.catch_cosine;
    }
    if (out.event) state.snapped = !state.snapped;

    Detent detent;
    if (state.snapped) {
        out.patient_from_needle = {patient_from_guide.rotation,
                                   patient_from_guide.position_m + height_m * rail};
        detent = {s.stiffness_n_per_m * r_m, 0.5 * s.stiffness_n_per_m * r_m * r_m};
    } else if (free && at_rail) {
        detent = freeDetent(s, r_m);
    }
    state.across_m = across;
    out.energy_j = detent.energy_j;
    if (r_m > 0.0) out.force_n = -(detent.force_n / r_m) * across;
    return out;
}

}  // namespace stylet::haptics
