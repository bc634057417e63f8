// The Novint Falcon's delta mechanism: conversion between grip position and thigh angles, and from force to
// torques.
//
// Facts from libnifalcon's FalconGeometry.h and FalconKinematicStamper.cpp (R. E. Stamper, A Three Degree of
// Freedom Parallel Manipulator, PhD thesis, 1997, and L.-W. Tsai for the mechanism). The formulas are
// derived independently in falcon_kinematics.cpp, because that driver's Jacobian wrongly squares a sine.
//
// Frame `device`: origin on the mechanism's axis, +x right, +y up, +z out of the base toward the user.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <optional>

#include "base/geometry.h"

namespace stylet::haptics::falcon {

// Thigh angles from their rest plane, in encoder order: top, right, left.
using Angles = Vec3;  // rad
using Counts = std::array<std::int16_t, 3>;

// Grip position halfway out. The usable range is z = 0.075 to 0.17 m.
inline constexpr Vec3 kCentre_m{0.0, 0.0, 0.11};

// Encoders: 320 lines with four edges each, on a 14.25 mm shaft driving a 110 mm drum. The offset of 35
// degrees is "approximate" in the source.
double radiansFromCounts(double counts) noexcept;
double countsFromRadians(double radians) noexcept;
Angles anglesFromCounts(const Counts&) noexcept;

// Closed form. Empty if the legs cannot reach the position.
std::optional<Angles> anglesAt(const Vec3& grip_m) noexcept;

// d(angles)/d(grip), rad/m; row i is leg i. Empty if a leg is stretched out or folded flat.
std::optional<glm::dmat3> jacobianAt(const Vec3& grip_m) noexcept;

// Newton iteration from `near_m` (the last grip position), then from the centre. Empty if neither converges
// to within 1e-9 rad, so that an old position is never mistaken for a new one.
std::optional<Vec3> gripFromAngles(const Angles&, const Vec3& near_m) noexcept;

// Thigh torques, N m, that produce `force_n` at the grip. Virtual work: torque = (d grip / d angles)^T f.
std::optional<Vec3> computeTorques(const Vec3& force_n, const Vec3& grip_m) noexcept;

}  // namespace stylet::haptics::falcon
