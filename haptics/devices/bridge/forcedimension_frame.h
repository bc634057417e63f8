// Conversion between Force Dimension's frame (x toward the user, y to the user's right, z up; used by the
// SDK and CHAI3D) and the bridge's (x right, y up, z toward the user).
#pragma once

#include <glm/gtc/quaternion.hpp>

#include "haptics/tools/device.h"

namespace stylet::haptics::bridge {

inline Vec3 bridgeFromDhd(const Vec3& v) noexcept {
    return {v.y, v.z, v.x};
}
inline Vec3 dhdFromBridge(const Vec3& v) noexcept {
    return {v.z, v.x, v.y};
}

// `rows` is the rotation as the SDK gives it. With the identity rotation the wrist holds the stylus level,
// its tip away from the user.
inline Pose stylusFromDhd(const Vec3& position_m, const double (&rows)[3][3]) noexcept {
    const glm::dmat3 wrist(rows[0][0], rows[1][0], rows[2][0], rows[0][1], rows[1][1], rows[2][1], rows[0][2],
                           rows[1][2], rows[2][2]);
    // A third of a turn: x to z, y to x, z to y.
    const Quat bridge_from_dhd(0.5, -0.5, -0.5, -0.5);
    const Quat turned =
        bridge_from_dhd * glm::normalize(glm::quat_cast(wrist)) * glm::conjugate(bridge_from_dhd);
    return {turned, bridgeFromDhd(position_m)};
}

}  // namespace stylet::haptics::bridge
