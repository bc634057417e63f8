// Formulas for a border that resists puncture (tenting), shared by the sampled and the exact solver. Based
// on Mastmeyer et al. 2017, Eq. 1, with a2 chosen so that the force reaches T_N at the same depth for every
// a1.
#pragma once

#include <algorithm>
#include <cmath>

#include "patient/tissue/tissue.h"

namespace stylet::haptics {

// A force within this tolerance of the threshold punctures at once. Otherwise rounding could make a border
// tent when the friction equals its threshold.
inline constexpr double kCutTolerance_n = 1e-6;

// True for a tissue that no force punctures (bone).
inline bool isRigid(const patient::TissueRow& row) noexcept {
    return std::isinf(row.cut_force_n);
}

// True if the threshold of `row` resists a needle that arrives with `force_n`.
inline bool resists(const patient::TissueRow& row, double force_n) noexcept {
    return row.stiffness_n_per_m > 0.0 && row.cut_force_n > force_n + kCutTolerance_n;
}

// R, the friction of a tissue on a needle with this scale (NeedleSettings::friction_scale).
inline double frictionLimit(const patient::TissueRow& row, double friction_scale) noexcept {
    return row.friction_n * friction_scale;
}

// Force just after entering a tissue: clamped to [-R, R], its friction. Zero for a tissue without
// stiffness.
inline double clampToFriction(const patient::TissueRow& row, double force_n, double friction_scale) noexcept {
    const double most_n = frictionLimit(row, friction_scale);
    return row.stiffness_n_per_m > 0.0 ? std::clamp(force_n, -most_n, most_n) : 0.0;
}

// f(d) = a2 d^2 + a1 d + a0, where d is the depth of the tip behind the border, 0 <= d <= cut_depth_m.
struct TentingCurve {
    double a0_n = 0.0, a1_n_per_m = 0.0, a2_n_per_m2 = 0.0;
    double cut_depth_m = 0.0;  // d*, the puncture depth; infinite for a rigid tissue

    double force_n(double depth_m) const noexcept {
        return (a2_n_per_m2 * depth_m + a1_n_per_m) * depth_m + a0_n;
    }
    // Work done by f from the border to depth d.
    double energy_j(double depth_m) const noexcept {
        return ((a2_n_per_m2 / 3.0 * depth_m + a1_n_per_m / 2.0) * depth_m + a0_n) * depth_m;
    }
    // Slope of f. At most 2 k_B - a1, reached at d*.
    double tangent_n_per_m(double depth_m) const noexcept { return 2.0 * a2_n_per_m2 * depth_m + a1_n_per_m; }
};

// Force curve for entering `row` with force a0 on arrival; a1 = a1_share * k_B. A rigid tissue is a linear
// spring.
inline TentingCurve tentingCurve(const patient::TissueRow& row, double a0_n, double a1_share) noexcept {
    const double k = row.stiffness_n_per_m;
    if (isRigid(row)) return {a0_n, k, 0.0, row.cut_force_n};
    const double rise_n = row.cut_force_n - a0_n;
    const double a1 = a1_share * k;
    return {a0_n, a1, k * (k - a1) / std::fabs(rise_n), rise_n / k};
}

}  // namespace stylet::haptics
