// Motions with known answers, sampled from functions.
#pragma once

#include <functional>

#include "patient/patient.h"

namespace stylet::test {

using patient::Vec3;

// What a motion is at a point of the reference.
struct MotionPoint {
    Vec3 wall_a1_m{0.0}, wall_a2_m_s{0.0}, slide_a1_m{0.0}, slide_a2_m_s{0.0};
    double level_m = -1.0;
};

// `half_m` around the origin; the outermost nodes stand still, whatever the function says.
patient::MotionModel makeMotion(const Vec3& half_m, double spacing_m,
                                const std::function<MotionPoint(const Vec3&)>& at);

// Everything within 0.2 m of the origin moves by `travel_m` along z at v = 1, and fades within 0.1 m around.
patient::MotionModel makeShift(double travel_m);

// Rises from 0 at `from` to 1 at `to`, C1; `from` may be the greater.
double rise(double from, double to, double x);

// Inside of a sphere about the origin that turns about z; the rest stands still.
patient::MotionModel makeTurningBall(double radius_m, double angle_rad, double spacing_m);

// Stretches, shears and turns by turns within 0.12 m of the origin, all of it inside; steeper than a patient.
patient::MotionModel makeBending();

}  // namespace stylet::test
