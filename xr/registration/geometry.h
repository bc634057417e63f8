// Points and rigid transforms of the registration. Metres, seconds, double precision.
// Frames: device (base of the haptic device), stylus (its handle, origin at the tip), grip (tracked
// controller), stage (the room).
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace stylet::xr::registration {

using Vec3 = glm::dvec3;
using Quat = glm::dquat;

struct Rigid {  // a_from_b
    Quat rotation{1.0, 0.0, 0.0, 0.0};
    Vec3 position_m{0.0};

    Vec3 operator*(const Vec3& p) const { return rotation * p + position_m; }
    Rigid operator*(const Rigid& c_from_b) const {
        return {rotation * c_from_b.rotation, rotation * c_from_b.position_m + position_m};
    }
    Rigid inverse() const {
        const Quat back = glm::conjugate(rotation);
        return {back, back * -position_m};
    }
};

inline bool isFinite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool isFinite(const Rigid& r) {
    return isFinite(r.position_m) && std::isfinite(r.rotation.w) &&
           isFinite(Vec3(r.rotation.x, r.rotation.y, r.rotation.z));
}
// Angle between two orientations [rad].
inline double angleBetween(const Quat& a, const Quat& b) {
    const Quat turn = glm::conjugate(a) * b;
    return 2.0 * std::atan2(glm::length(Vec3(turn.x, turn.y, turn.z)), std::fabs(turn.w));
}

// A value, or one sentence with the reason why there is none.
template <typename T>
struct Answer {
    std::optional<T> value;
    std::string why_not;

    explicit operator bool() const { return value.has_value(); }
    const T& operator*() const { return *value; }
    const T* operator->() const { return &*value; }
};
template <typename T>
Answer<T> refused(std::string why_not) {
    return {std::nullopt, std::move(why_not)};
}

}  // namespace stylet::xr::registration
