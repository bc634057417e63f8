#include "patient/synth/shapes.h"

namespace stylet::patient::synth {

OrientedEllipsoid orientedEllipsoid(const Vec3& centre, const Vec3& along, const Vec3& second,
                                    const Vec3& radii) {
    const Vec3 u = unitOr(along, Vec3(1, 0, 0));
    const Vec3 v = unitOr(second - u * dot(u, second), Vec3(0, 1, 0));
    return {centre, {u, v, cross(u, v)}, radii};
}

double curve(std::span<const Knot> knots, double x) noexcept {
    if (x <= knots.front().x) return knots.front().y;
    if (x >= knots.back().x) return knots.back().y;
    std::size_t i = 0;
    while (x >= knots[i + 1].x)
        ++i;
    const Knot &a = knots[i], &b = knots[i + 1];
    const Knot& before = knots[i > 0 ? i - 1 : i];
    const Knot& after = knots[std::min(i + 2, knots.size() - 1)];
    const double width = b.x - a.x, t = (x - a.x) / width;
    const double slope_a = i > 0 ? (b.y - before.y) / (b.x - before.x) : (b.y - a.y) / width;
    const double slope_b = i + 2 < knots.size() ? (after.y - a.y) / (after.x - a.x) : (b.y - a.y) / width;
    const double t2 = t * t, t3 = t2 * t;
    return a.y * (2 * t3 - 3 * t2 + 1) + b.y * (3 * t2 - 2 * t3) +
           width * (slope_a * (t3 - 2 * t2 + t) + slope_b * (t3 - t2));
}

}  // namespace stylet::patient::synth
