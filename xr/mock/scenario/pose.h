// Rigid transforms in double precision. Metres; right-handed, y up, -z forward, as in OpenXR.
#pragma once

#include <array>

#include "scenario/openxr_api.h"

namespace xrmock {

using Vec3 = std::array<double, 3>;

struct Pose {
    std::array<double, 4> orientation{0, 0, 0, 1};  // x y z w, unit length
    Vec3 position{0, 0, 0};
};

Pose operator*(const Pose& a_from_b, const Pose& b_from_c);
Pose inverse(const Pose& a_from_b);
// Interpolates linearly in position and spherically in orientation, along the shorter arc.
Pose interpolate(const Pose& from, const Pose& to, double fraction);
// The upright pose: same position, keeping only the rotation about y.
Pose yawOnly(const Pose& pose);
// Rotation vector [rad] from `from` to `to`.
Vec3 rotationBetween(const Pose& from, const Pose& to);

// Returns whether the pose is finite and its quaternion has unit length within 1 %.
bool isValid(const XrPosef& pose);
Pose fromXr(const XrPosef& pose);
XrPosef toXr(const Pose& pose);
XrVector3f toXr(const Vec3& v);

}  // namespace xrmock
