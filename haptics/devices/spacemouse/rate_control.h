// Rate control with a dead zone: the deflection of a sprung cap sets the velocity of a pose.
#pragma once

#include <array>

#include "base/geometry.h"

namespace stylet::haptics {

struct RateSettings {
    double full_scale = 350.0;  // axis value at full deflection
    // Fraction of full scale without motion: caps do not spring back exactly to 0.
    double dead_zone = 0.08;
    double speed_m_s = 0.08;   // at full scale
    double turn_rad_s = 0.8;   // at full scale
    double reach_m = 0.15;     // the position stays in a sphere about the origin
    double max_step_s = 0.02;  // longest time step; limits the motion after a clock jump
};

// Returns -1..1: 0 in the dead zone, then the square of the remaining deflection, so that slow motion is
// easy.
double rateShare(double axis, const RateSettings&) noexcept;

// Moves `pose` for `dt_s`. `axes` are three translations along and three rotations about x, y, z of the
// pose's parent frame. Rotation is about the pose's own origin. noexcept, no allocation.
void stepRate(Pose&, const std::array<double, 6>& axes, const RateSettings&, double dt_s) noexcept;

}  // namespace stylet::haptics
