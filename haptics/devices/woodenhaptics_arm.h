// The arm of a WoodenHaptics: where it is, and what its motors must do for a force.
// Facts from forsslund/haptikfabrikenapi (src/kinematics.cpp: position, orientation, motor directions). The
// Jacobian and the gravity torque are derived here: the library's gravity term is no gradient of a potential.
//
// Base frame: +z up along the first axis, +x out toward the user, +y to his right. Angles a about +z; b of
// the upper arm from the vertical; c of the forearm from straight down, absolute (a parallelogram drives it).
#pragma once

#include <array>
#include <cstdint>

#include <glm/mat3x3.hpp>

#include "haptics/devices/woodenhaptics_model.h"

namespace stylet::haptics {

using patient::Quat;
using patient::Vec3;

using ArmCounts = std::array<int, 6>;  // encoders a..f

inline constexpr double kMostCurrent_a = 2.0;  // the amplifiers bear no more for long

Vec3 armAngles_rad(const WoodenModel&, const ArmCounts&) noexcept;
// Of the tip, base frame, from the workspace's origin.
Vec3 armPosition_m(const WoodenModel&, const Vec3& angles_rad) noexcept;
// Column i is the derivative of the position by angle i, m/rad.
glm::dmat3 armJacobian(const WoodenModel&, const Vec3& angles_rad) noexcept;
// Of the stylus, base frame; +x points along it, away from the arm. Without a wrist: identity.
Quat armRotation(const WoodenModel&, const Vec3& angles_rad, const ArmCounts&) noexcept;

// On the bodies, that holds the arm against its own weight, N m.
Vec3 armGravityTorque_n_m(const WoodenModel&, const Vec3& angles_rad) noexcept;

struct ArmCurrents {
    Vec3 motor_a{0.0};
    bool limited = false;  // the force's share was cut, in its own direction
};
// For a force on the user's hand, base frame. Never more than kMostCurrent_a in any motor; the arm's weight
// is held first, and what is left goes to the force. A force that is not finite is none.
ArmCurrents armCurrents(const WoodenModel&, const Vec3& angles_rad, const Vec3& force_n) noexcept;

// How far one count of each encoder moves the tip, root of the sum of squares.
double armResolution_m(const WoodenModel&, const Vec3& angles_rad) noexcept;

}  // namespace stylet::haptics
