// The formulas of a border that holds the needle back, written once for the sampled and the exact solver.
// Based on Mastmeyer et al. 2017, Eq. 1 with a2 chosen so that every a1 reaches T_N at the same depth.
#pragma once

#include <algorithm>
#include <cmath>

#include "patient/tissue.h"

namespace stylet::haptics {

// Forces within this of the threshold cut at once: friction equal to the next threshold must not hold on
// rounding.
inline constexpr double kCutTolerance_n = 1e-6;

// Never cut, whatever the force (bone).
inline bool isRigid(const patient::TissueRow& row) noexcept {
    return std::isinf(row.cut_force_n);
}

// Would the threshold of `row` hold a needle that arrives with `force_n`?
inline bool resists(const patient::TissueRow& row, double force_n) noexcept {
    return row.stiffness_n_per_m > 0.0 && row.cut_force_n > force_n + kCutTolerance_n;
}

// What a tissue's friction leaves of a force on entering it: g in [-R, R]; nothing where there is no
// stiffness.
inline double clampToFriction(const patient::TissueRow& row, double force_n) noexcept {
    return row.stiffness_n_per_m > 0.0 ? std::clamp(force_n, -row.friction_n, row.friction_n) : 0.0;
}

// f(d) = a2 d^2 + a1 d + a0 for a tip d behind the border, 0 <= d <= cut_depth_m.
struct HoldCurve {
    double a0_n = 0.0, a1_n_per_m = 0.0, a2_n_per_m2 = 0.0;
    double cut_depth_m = 0.0;  // d*, infinite for a rigid tissue

    double force_n(double depth_m) const noexcept {
        return (a2_n_per_m2 * depth_m + a1_n_per_m) * depth_m + a0_n;
    }
    // The work done by f from the border to d.
    double energy_j(double depth_m) const noexcept {
        return ((a2_n_per_m2 / 3.0 * depth_m + a1_n_per_m / 2.0) * depth_m + a0_n) * depth_m;
    }
    // At most 2 k_B - a1, at d*.
    double tangent_n_per_m(double depth_m) const noexcept { return 2.0 * a2_n_per_m2 * depth_m + a1_n_per_m; }
};

// The curve of entering `row` with force a0 on arrival; a1 = share * k_B. A rigid tissue is a plain spring.
inline HoldCurve holdCurve(const patient::TissueRow& row, double a0_n, double a1_share) noexcept {
    const double k = row.stiffness_n_per_m;
    if (isRigid(row)) return {a0_n, k, 0.0, row.cut_force_n};
    const double rise_n = row.cut_force_n - a0_n;
    const double a1 = a1_share * k;
    return {a0_n, a1, k * (k - a1) / std::fabs(rise_n), rise_n / k};
}

}  // namespace stylet::haptics
