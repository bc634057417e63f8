// Implicit shapes in millimetres: negative inside, distances accurate to first order near the surface.
// Smooth maximum and minimum after Quilez, "Smooth minimum" (polynomial form).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <span>

#include "base/geometry.h"
#include "base/smoothstep.h"

namespace stylet::patient::synth {

inline double smoothMax(double a, double b, double k) noexcept {
    const double h = std::max(k - std::fabs(a - b), 0.0) / k;
    return std::max(a, b) + h * h * k * 0.25;
}
inline double smoothMin(double a, double b, double k) noexcept {
    return -smoothMax(-a, -b, k);
}
inline double clamp01(double t) noexcept {
    return std::clamp(t, 0.0, 1.0);
}
// Smoothstep: 0 at `from`, 1 at `to` (either order), C1.
inline double ramp(double x, double from, double to) noexcept {
    return smoothStep(from, to, x);
}
// 1 at r2 = 0, falling like a Lorentzian; r2 is a squared normalised distance.
inline double bump(double r2) noexcept {
    return 1.0 / (1.0 + r2 * r2);
}

inline Vec3 unitOr(const Vec3& v, const Vec3& otherwise) noexcept {
    const double n = length(v);
    return n > 1e-9 ? v / n : otherwise;
}
inline Vec3 mixed(const Vec3& a, const Vec3& b, double t) noexcept {
    return a * (1.0 - t) + b * t;
}

inline double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) noexcept {
    const Vec3 e = (p - centre) / radii;
    const double rho = length(e);
    const double gradient = length(e / radii);
    return gradient > 1e-12 ? (rho - 1.0) * rho / gradient : -std::min({radii.x, radii.y, radii.z});
}

// An ellipsoid whose axes are the (orthonormal) columns of `axes`.
struct OrientedEllipsoid {
    Vec3 centre{0.0};
    std::array<Vec3, 3> axes{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    Vec3 radii{1.0};
    double distance(const Vec3& p) const noexcept {
        const Vec3 q = p - centre;
        return ellipsoid({dot(q, axes[0]), dot(q, axes[1]), dot(q, axes[2])}, Vec3(0.0), radii);
    }
};
// Long axis along `along`; second axis as close to `second` as possible.
OrientedEllipsoid orientedEllipsoid(const Vec3& centre, const Vec3& along, const Vec3& second,
                                    const Vec3& radii);

// A cone with round ends. `share` is the position of the nearest axis point along the axis.
struct ConeHit {
    double distance, share;
};
inline ConeHit roundCone(const Vec3& p, const Vec3& a, const Vec3& b, double ra, double rb) noexcept {
    const Vec3 ab = b - a, ap = p - a;
    const double n = dot(ab, ab);
    const double t = n > 0.0 ? clamp01(dot(ap, ab) / n) : 0.0;
    return {length(ap - ab * t) - (ra + (rb - ra) * t), t};
}

// Interpolates values at ascending knots: Catmull-Rom in between, constant outside.
struct Knot {
    double x, y;
};
double curve(std::span<const Knot> knots, double x) noexcept;

}  // namespace stylet::patient::synth
