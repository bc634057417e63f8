// Points and rigid transforms of the registration. Metres, seconds, double precision.
// Frames: device (base of the haptic device), stylus (its handle, origin at the tip), grip (tracked
// controller), stage (the room).
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <string>

#include "base/geometry.h"

namespace stylet::xr::registration {

// Angle between two orientations [rad].
inline double angleBetween(const Quat& a, const Quat& b) {
    const Quat turn = glm::conjugate(a) * b;
    return 2.0 * std::atan2(glm::length(Vec3(turn.x, turn.y, turn.z)), std::fabs(turn.w));
}
// Largest rotation between two of the poses [rad]. Compares with `from`, then with the orientation farthest
// from it: within a few per cent of the maximum over all pairs.
inline double maxRotation_rad(Quat from, std::span<const Pose> poses) {
    double largest_rad = 0.0;
    for (int round = 0; round < 2; ++round) {
        Quat farthest = from;
        for (const Pose& pose : poses)
            if (const double turn = angleBetween(from, pose.rotation); turn > largest_rad)
                largest_rad = turn, farthest = pose.rotation;
        from = farthest;
    }
    return largest_rad;
}

// A value, or one sentence with the reason why there is none.
template <typename T>
struct Result {
    std::optional<T> value;
    std::string why_not;

    explicit operator bool() const { return value.has_value(); }
    const T& operator*() const { return *value; }
    const T* operator->() const { return &*value; }
};
template <typename T>
Result<T> failure(std::string why_not) {
    return {std::nullopt, std::move(why_not)};
}

}  // namespace stylet::xr::registration
