// Where the tip of a tracked stylus is, from turning it about a point that rests.
// Based on Z. Yaniv, Which pivot calibration?, Proc. SPIE 9415 (2015): the algebraic one-step form.
#pragma once

#include <span>

#include "xr/registration/geometry.h"

namespace stylet::xr::registration {

struct Pivot {
    Vec3 grip_from_tip_m{0.0};
    Vec3 stage_from_pivot_m{0.0};
    double residual_m = 0.0;  // root mean square
    double tip_sd_m = 0.0;    // of the tip's worst direction, from the residual
    double turned_rad = 0.0;  // the largest angle between two of the orientations
};

// R_i tip + p_i = pivot for all i, least squares; poses that the rest contradicts are left out. Refuses fewer
// than eight poses, too little turning (25 degrees, and about more than one axis), and numbers that are none.
Answer<Pivot> calibratePivot(std::span<const Rigid> stage_from_grip);

}  // namespace stylet::xr::registration
