// Motion models with known results, sampled from functions.
#pragma once

#include <functional>

#include "patient/patient.h"

namespace stylet::test {

// Motion at a reference point.
struct MotionPoint {
    Vec3 wall_a1_m{0.0}, wall_a2_m_s{0.0}, slide_a1_m{0.0}, slide_a2_m_s{0.0};
    double level_m = -1.0;
};

// The grid covers +-`half_m` around the origin. The outermost nodes are at rest, whatever `at` returns.
patient::MotionModel makeMotion(const Vec3& half_m, double spacing_m,
                                const std::function<MotionPoint(const Vec3&)>& at);

// Everything within 0.2 m of the origin moves by `travel_m` along z at v = 1. The motion fades to zero over
// the next 0.1 m.
patient::MotionModel makeShift(double travel_m);

// A sphere around the origin that turns about z; everything outside is at rest.
patient::MotionModel makeTurningBall(double radius_m, double angle_rad, double spacing_m);

// Stretch, shear and rotation that vary with position within 0.12 m of the origin, all inside the cavity.
// Steeper than in a patient.
patient::MotionModel makeBending();

}  // namespace stylet::test
