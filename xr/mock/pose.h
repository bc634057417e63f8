// Rigid transforms in double precision. Metres; right-handed, y up, -z forward, as OpenXR has them.
#pragma once

#include <array>

#include "openxr_api.h"

namespace xrmock {

using Vec3 = std::array<double, 3>;

struct Pose {
    std::array<double, 4> orientation{0, 0, 0, 1};  // x y z w, unit length
    Vec3 position{0, 0, 0};
};

Pose operator*(const Pose& a_from_b, const Pose& b_from_c);
Pose inverse(const Pose& a_from_b);
// Linear in position, spherical in orientation, along the shorter arc.
Pose interpolate(const Pose& from, const Pose& to, double fraction);
// The pose turned back to upright: same position, only the rotation about y.
Pose yawOnly(const Pose& pose);
// The rotation vector (radians) that turns `from` into `to`.
Vec3 rotationBetween(const Pose& from, const Pose& to);

// Finite and, within one percent, of unit length.
bool isValid(const XrPosef& pose);
Pose fromXr(const XrPosef& pose);
XrPosef toXr(const Pose& pose);

}  // namespace xrmock
