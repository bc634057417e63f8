// Quadratic B-splines over the nodes of a grid: C1, no overshoot, linear functions are reproduced.
// Evaluating a point reads 27 nodes.
#pragma once

#include <algorithm>
#include <array>

#include "base/volume.h"

namespace stylet {

// Values and slopes (per metre) of N quantities at one point.
template <int N>
struct SplineSample {
    std::array<double, N> value{};
    std::array<Vec3, N> slope{};
    double beyond_m = 0.0;  // distance from the grid; outside it, the sample is that of the edge
};

// `nodes` holds N floats per node, x-fastest, with at least three nodes per side. NaN is treated as the
// low end. Any thread. noexcept, no allocation.
template <int N>
SplineSample<N> sampleSpline(const Grid& grid, const float* nodes, const Vec3& p) noexcept {
    SplineSample<N> out;
    double w[3][3], s[3][3];
    std::size_t first = 0, stride = 1, step[3];
    Vec3 inside;
    for (int axis = 0; axis < 3; ++axis) {
        const double last = double(grid.dims[axis]) - 1.5;
        const double per_m = 1.0 / grid.spacing_m[axis];
        const double at = (p[axis] - grid.origin_m[axis]) * per_m;
        const double v = at > 0.5 ? std::min(at, last) : 0.5;
        const int middle = std::min(int(v + 0.5), grid.dims[axis] - 2);
        const double t = v - double(middle);
        w[axis][0] = 0.5 * (0.5 - t) * (0.5 - t);
        w[axis][1] = 0.75 - t * t;
        w[axis][2] = 0.5 * (0.5 + t) * (0.5 + t);
        s[axis][0] = (t - 0.5) * per_m;
        s[axis][1] = -2.0 * t * per_m;
        s[axis][2] = (t + 0.5) * per_m;
        first += std::size_t(middle - 1) * stride;
        step[axis] = stride;
        stride *= std::size_t(grid.dims[axis]);
        inside[axis] = grid.origin_m[axis] + v * grid.spacing_m[axis];
    }
    for (std::size_t z = 0; z < 3; ++z)
        for (std::size_t y = 0; y < 3; ++y) {
            const float* const n = nodes + std::size_t(N) * (first + z * step[2] + y * step[1]);
            const double wyz = w[1][y] * w[2][z], sy = s[1][y] * w[2][z], sz = w[1][y] * s[2][z];
            for (std::size_t q = 0; q < std::size_t(N); ++q) {
                const double a = double(n[q]), b = double(n[N + q]), c = double(n[2 * N + q]);
                const double along = w[0][0] * a + w[0][1] * b + w[0][2] * c;
                out.value[q] += wyz * along;
                out.slope[q].x += wyz * (s[0][0] * a + s[0][1] * b + s[0][2] * c);
                out.slope[q].y += sy * along;
                out.slope[q].z += sz * along;
            }
        }
    const Vec3 out_by = p - inside;
    out.beyond_m = std::sqrt(glm::dot(out_by, out_by));
    return out;
}

}  // namespace stylet
