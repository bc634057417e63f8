// Poses of spaces at a time. In this file "stage" means the room frame, which equals STAGE at the start (see
// conditions.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "world/objects.h"

namespace xrmock {

inline constexpr XrSpaceLocationFlags kLocated =
    XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT |
    XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT | XR_SPACE_LOCATION_POSITION_TRACKED_BIT;

Pose stageFromHead(const Instance& instance, std::int64_t time_ns);
// Until it is recentred, LOCAL is upright at the head's position of scenario time 0.
Pose stageFromLocal(const Instance& instance, std::int64_t time_ns);
// XR_EXT_local_floor: LOCAL lowered to the floor of STAGE.
Pose stageFromLocalFloor(const Instance& instance, std::int64_t time_ns);
std::array<Pose, 2> stageFromEyes(const Instance& instance, std::int64_t time_ns);

// Returns nullopt for an action space without an active device.
std::optional<Pose> stageFromSpace(const Space& space, std::int64_t time_ns);
std::optional<Pose> baseFromSpace(const Space& base, const Space& space, std::int64_t time_ns);

struct Velocity {
    Vec3 linear_m_per_s;
    Vec3 angular_rad_per_s;
};
inline constexpr XrSpaceVelocityFlags kMoving =
    XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
// Velocity between the poses kStepNs before and kStepNs after a time.
inline constexpr std::int64_t kStepNs = 500'000;
Velocity centralDifference(const Pose& before, const Pose& after);
// Velocity of the origin of `space` relative to `base`, in the axes of `base`.
std::optional<Velocity> velocityInBase(const Space& base, const Space& space, std::int64_t time_ns);

}  // namespace xrmock
