// Does a registration still hold? One place or more touched again says so.
#pragma once

#include <span>
#include <string>

#include "xr/registration/fit.h"

namespace stylet::xr::registration {

// What is left of a fit when it has been stored.
struct Stored {
    Rigid stage_from_device;
    double scale = 1.0;
    Vec3 stylus_from_tip_m{0.0}, grip_from_tip_m{0.0};
    double noise_m = 0.001;    // of a touch, along an axis
    double tre_worst_m = 0.0;  // root mean square
};

struct Drift {
    bool holds = false;
    double moved_m = 0.0;    // mean of the touches' misses: a shift
    double allowed_m = 0.0;  // 99 % of good touches miss by less
    std::string what;        // a sentence
};

// The touches' mean miss against what noise and the registration's own error make of it. No touch, or a
// number that is none, holds nothing.
Drift judgeDrift(const Stored&, std::span<const Pair> touched);

}  // namespace stylet::xr::registration
