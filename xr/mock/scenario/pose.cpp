#include "scenario/pose.h"

#include <cmath>

namespace xrmock {

namespace {

using Quat = std::array<double, 4>;

Quat multiply(const Quat& a, const Quat& b) {
    return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
            a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
            a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
            a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

Quat conjugate(const Quat& q) {
    return {-q[0], -q[1], -q[2], q[3]};
}

Quat normalized(const Quat& q) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

Vec3 rotate(const Quat& q, const Vec3& v) {
    const Quat rotated = multiply(multiply(q, {v[0], v[1], v[2], 0}), conjugate(q));
    return {rotated[0], rotated[1], rotated[2]};
}

}  // namespace

Pose operator*(const Pose& a_from_b, const Pose& b_from_c) {
    const Vec3 moved = rotate(a_from_b.orientation, b_from_c.position);
    return {
        normalized(multiply(a_from_b.orientation, b_from_c.orientation)),
        {a_from_b.position[0] + moved[0], a_from_b.position[1] + moved[1], a_from_b.position[2] + moved[2]}};
}

Pose inverse(const Pose& a_from_b) {
    const Quat back = conjugate(a_from_b.orientation);
    const Vec3& p = a_from_b.position;
    return {back, rotate(back, {-p[0], -p[1], -p[2]})};
}

Pose interpolate(const Pose& from, const Pose& to, double fraction) {
    Pose result;
    for (int i = 0; i < 3; ++i)
        result.position[i] = from.position[i] + (to.position[i] - from.position[i]) * fraction;
    double cosine = 0;
    for (int i = 0; i < 4; ++i)
        cosine += from.orientation[i] * to.orientation[i];
    const double sign = cosine < 0 ? -1.0 : 1.0;
    cosine *= sign;
    double weight_from = 1.0 - fraction;
    double weight_to = fraction;
    if (cosine < 0.9999) {  // closer than that, linear interpolation is accurate
        const double angle = std::acos(cosine);
        weight_from = std::sin(weight_from * angle) / std::sin(angle);
        weight_to = std::sin(weight_to * angle) / std::sin(angle);
    }
    for (int i = 0; i < 4; ++i)
        result.orientation[i] = weight_from * from.orientation[i] + sign * weight_to * to.orientation[i];
    result.orientation = normalized(result.orientation);
    return result;
}

Pose yawOnly(const Pose& pose) {
    const double y = pose.orientation[1];
    const double w = pose.orientation[3];
    const double length = std::sqrt(y * y + w * w);
    if (length < 1e-9) return {{0, 1, 0, 0}, pose.position};  // upside down, so the yaw is undefined
    return {{0, y / length, 0, w / length}, pose.position};
}

Vec3 rotationBetween(const Pose& from, const Pose& to) {
    Quat turn = multiply(to.orientation, conjugate(from.orientation));
    if (turn[3] < 0) turn = {-turn[0], -turn[1], -turn[2], -turn[3]};
    const double sine = std::sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    const double scale = sine < 1e-12 ? 2.0 : 2.0 * std::atan2(sine, turn[3]) / sine;
    return {turn[0] * scale, turn[1] * scale, turn[2] * scale};
}

bool isValid(const XrPosef& pose) {
    const XrQuaternionf& q = pose.orientation;
    const XrVector3f& p = pose.position;
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return false;
    const double length =
        std::sqrt(double{q.x} * q.x + double{q.y} * q.y + double{q.z} * q.z + double{q.w} * q.w);
    return length > 0.99 && length < 1.01;  // false for NaN too
}

Pose fromXr(const XrPosef& pose) {
    const XrQuaternionf& q = pose.orientation;
    return {normalized({q.x, q.y, q.z, q.w}), {pose.position.x, pose.position.y, pose.position.z}};
}

XrPosef toXr(const Pose& pose) {
    const auto& q = pose.orientation;
    return {{static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2]),
             static_cast<float>(q[3])},
            toXr(pose.position)};
}

XrVector3f toXr(const Vec3& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

}  // namespace xrmock
