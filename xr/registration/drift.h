// Checks whether a stored registration is still valid, from one or more places touched again.
#pragma once

#include <span>
#include <string>

#include "xr/registration/fit.h"

namespace stylet::xr::registration {

// The part of a fit that is stored.
struct StoredRegistration {
    Pose stage_from_device;
    double scale = 1.0;
    Vec3 stylus_from_tip_m{0.0}, grip_from_tip_m{0.0};
    double noise_m = 0.001;    // standard deviation of a touch, per axis
    double tre_worst_m = 0.0;  // RMS at the worst corner of the cube
};

struct Drift {
    bool valid = false;
    double moved_m = 0.0;    // length of the mean error vector, or the RMS error after a rotation
    double allowed_m = 0.0;  // 99th percentile of the same error for a valid registration
    std::string what;        // one sentence for the user
};

// Compares the error of the touches with the error expected from noise and from the registration itself.
// `valid` is false without touches and for non-finite numbers.
Drift checkDrift(const StoredRegistration&, std::span<const Pair> touched);

}  // namespace stylet::xr::registration
