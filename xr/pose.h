// Conversion of poses from and to OpenXR.
#pragma once

#include "xr/check.h"

namespace stylet::xr {

inline constexpr XrPosef kIdentityPose{{0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}};

Pose toPose(const XrPosef&);
XrPosef toXrPose(const Pose&);  // normalises the quaternion

// Returns the pose if `flags` contains all of `needed`. For rendering, a pose may be inferred (kWholePose);
// for measurements it must be tracked (kTracked).
inline constexpr XrSpaceLocationFlags kWholePose =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
inline constexpr XrSpaceLocationFlags kTracked =
    kWholePose | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;
inline std::optional<Pose> wholePose(XrSpaceLocationFlags flags, const XrPosef& pose,
                                     XrSpaceLocationFlags needed = kWholePose) {
    if ((flags & needed) != needed) return std::nullopt;
    return toPose(pose);
}

}  // namespace stylet::xr
