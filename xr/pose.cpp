#include "xr/pose.h"

#include <cmath>

namespace stylet::xr {

Pose toPose(const XrPosef& p) {
    return {{p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w},
            {p.position.x, p.position.y, p.position.z}};
}

XrPosef toXrPose(const Pose& p) {
    const auto& [x, y, z, w] = p.orientation;
    const double length = std::sqrt(x * x + y * y + z * z + w * w);
    return {{float(x / length), float(y / length), float(z / length), float(w / length)},
            {float(p.position[0]), float(p.position[1]), float(p.position[2])}};
}

std::array<double, 3> rotate(const Pose& by, const std::array<double, 3>& v) {
    const auto& [x, y, z, w] = by.orientation;
    // v + 2 w (q x v) + 2 q x (q x v)
    const std::array<double, 3> t{2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]),
                                  2 * (x * v[1] - y * v[0])};
    return {v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]};
}

Pose operator*(const Pose& a, const Pose& b) {
    const auto& [ax, ay, az, aw] = a.orientation;
    const auto& [bx, by, bz, bw] = b.orientation;
    Pose product;
    product.orientation = {aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                           aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz};
    product.position = rotate(a, b.position);
    for (std::size_t i = 0; i < 3; ++i)
        product.position[i] += a.position[i];
    return product;
}

Pose inverse(const Pose& a) {
    Pose back;
    back.orientation = {-a.orientation[0], -a.orientation[1], -a.orientation[2], a.orientation[3]};
    const std::array<double, 3> turned = rotate(back, a.position);
    back.position = {-turned[0], -turned[1], -turned[2]};
    return back;
}

}  // namespace stylet::xr
