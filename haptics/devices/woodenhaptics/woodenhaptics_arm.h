// The arm of a WoodenHaptics: its position, and the motor currents for a force.
// Facts from forsslund/haptikfabrikenapi (src/kinematics.cpp: position, orientation, motor directions). The
// Jacobian and the gravity torque are derived here, because the library's gravity term is not the gradient
// of a potential.
//
// Base frame: +z up along the first axis, +x out toward the user, +y to the user's right. Angles: a about
// +z; b of the upper arm from the vertical; c of the forearm from straight down. c does not depend on b,
// because a parallelogram drives the forearm.
#pragma once

#include <array>
#include <cstdint>

#include <glm/mat3x3.hpp>

#include "haptics/devices/woodenhaptics/woodenhaptics_model.h"

namespace stylet::haptics {

using ArmCounts = std::array<int, 6>;  // encoders a..f

inline constexpr double kMaxCurrent_a = 2.0;  // the amplifiers' continuous limit

Vec3 armAngles_rad(const WoodenModel&, const ArmCounts&) noexcept;
// Position of the tip, base frame, from the workspace's origin.
Vec3 armPosition_m(const WoodenModel&, const Vec3& angles_rad) noexcept;
// Column i is the derivative of the position with respect to angle i, m/rad.
glm::dmat3 armJacobian(const WoodenModel&, const Vec3& angles_rad) noexcept;
// Orientation of the stylus, base frame; +x points along it, away from the arm. Identity if there is no
// wrist.
Quat armRotation(const WoodenModel&, const Vec3& angles_rad, const ArmCounts&) noexcept;

// The torques, one per body, that hold the arm against its own weight, N m.
Vec3 armGravityTorque_n_m(const WoodenModel&, const Vec3& angles_rad) noexcept;

struct ArmCurrents {
    Vec3 motor_a{0.0};
    bool limited = false;  // the force was scaled down; its direction is kept
};
// Currents for a force on the user's hand, base frame. Never more than kMaxCurrent_a in any motor. The
// arm's weight is compensated first; the rest goes to the force. A non-finite force counts as zero.
ArmCurrents armCurrents(const WoodenModel&, const Vec3& angles_rad, const Vec3& force_n) noexcept;

// Tip motion for one count of each encoder, root of the sum of squares.
double armResolution_m(const WoodenModel&, const Vec3& angles_rad) noexcept;

}  // namespace stylet::haptics
