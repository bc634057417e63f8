// Pivot calibration: finds the tip of a tracked stylus that is rotated about a fixed point.
// Based on Z. Yaniv, Which pivot calibration?, Proc. SPIE 9415 (2015): the algebraic one-step form.
#pragma once

#include <span>

#include "xr/registration/geometry.h"

namespace stylet::xr::registration {

struct Pivot {
    Vec3 grip_from_tip_m{0.0};
    Vec3 stage_from_pivot_m{0.0};
    double residual_m = 0.0;        // root mean square
    double tip_sd_m = 0.0;          // standard deviation of the tip in its worst direction, from the residual
    double max_rotation_rad = 0.0;  // largest angle between two orientations
};

// Solves R_i tip + p_i = pivot for all i by least squares and rejects outliers. Refuses fewer than eight
// poses, too little rotation (less than 25 degrees, or about one axis only), and non-finite numbers.
Result<Pivot> calibratePivot(std::span<const Pose> stage_from_grip);

}  // namespace stylet::xr::registration
