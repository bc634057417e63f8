// The Novint Falcon's delta mechanism: grip position <-> thigh angles, and force -> torques.
//
// Facts from libnifalcon's FalconGeometry.h and FalconKinematicStamper.cpp (R. E. Stamper, A Three Degree of
// Freedom Parallel Manipulator, PhD thesis, 1997, and L.-W. Tsai for the mechanism). The formulae are derived
// anew in falcon_kinematics.cpp: that driver's Jacobian squares a sine that is not squared.
//
// Frame `device`: origin on the mechanism's axis, +x right, +y up, +z out of the base toward the user.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <optional>

#include "patient/geometry.h"

namespace stylet::haptics::falcon {

using patient::Vec3;

// Of the thighs from their rest plane, in the order of the encoders: top, right, left.
using Angles = Vec3;  // rad
using Counts = std::array<std::int16_t, 3>;

// Where the grip is halfway out; the usable span is z = 0.075 to 0.17 m.
inline constexpr Vec3 kCentre_m{0.0, 0.0, 0.11};

// 320 lines, four edges each, through a shaft of 14.25 mm on a drum of 110 mm. The offset of 35 degrees is
// "approximate" in the source.
double radiansFromCounts(double counts) noexcept;
double countsFromRadians(double radians) noexcept;
Angles anglesFromCounts(const Counts&) noexcept;

// Closed form. Nothing where no leg of these lengths reaches.
std::optional<Angles> anglesAt(const Vec3& grip_m) noexcept;

// d(angles)/d(grip), rad/m; row i is leg i. Nothing where a leg is stretched or folded flat.
std::optional<glm::dmat3> jacobianAt(const Vec3& grip_m) noexcept;

// Newton from `near_m` (the last grip position), then from the centre; nothing if neither arrives within
// 1e-9 rad, so that nobody takes an old position for a new one.
std::optional<Vec3> gripFromAngles(const Angles&, const Vec3& near_m) noexcept;

// The thighs' torques, N m, that make `force_n` at the grip: virtual work, torque = (d grip / d angles)^T f.
std::optional<Vec3> torquesFor(const Vec3& force_n, const Vec3& grip_m) noexcept;

}  // namespace stylet::haptics::falcon
