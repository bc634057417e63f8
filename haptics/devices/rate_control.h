// A pose steered by how far a sprung cap is pushed: rate control with a dead zone.
#pragma once

#include <array>

#include "patient/geometry.h"

namespace stylet::haptics {

struct RateSettings {
    double full_scale = 350.0;     // of an axis, its units
    double dead_zone = 0.08;       // share of the full scale that moves nothing: caps do not spring back to 0
    double speed_m_s = 0.08;       // at full scale
    double turn_rad_s = 0.8;       // at full scale
    double reach_m = 0.15;         // the position stays in a ball about the origin
    double longest_step_s = 0.02;  // a clock that jumps moves nothing further than in this time
};

// -1..1: 0 in the dead zone, then with the square of the way left, so that slow is easy.
double rateShare(double axis, const RateSettings&) noexcept;

// Moves `pose` for `dt_s`: three axes along and three about x, y, z of the frame that the pose is in. Turning
// is about the pose's own origin. noexcept, no allocation.
void stepRate(patient::Pose&, const std::array<double, 6>& axes, const RateSettings&, double dt_s) noexcept;

}  // namespace stylet::haptics
