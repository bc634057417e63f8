#include "app/modeller/segmentation/tubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "base/transcendental.h"

namespace stylet::modeller {

namespace {

// The value suggested by Sato et al. Along its axis, a tube may narrow or end, but hardly widens to a ball.
constexpr float kAlpha = 0.25f;
constexpr double kReach = 4.0;     // of a kernel, in sigmas; beyond it, values are below 1e-3 of the peak
constexpr double kMinSigma = 0.5;  // in voxels; below it, sampled kernels are not valid derivatives

using Kernel = std::vector<float>;  // odd length, the middle one at 0

// The Gaussian or its derivative of order 1 or 2, for sigma in voxels. Sampling and truncation cause small
// errors in the moments. These are corrected, so that the derivatives of constants, ramps and parabolas are
// exact.
Kernel gaussianKernel(double sigma, int order) {
    const int reach = std::max(2, int(std::ceil(kReach * sigma)));
    std::vector<double> k(std::size_t(2 * reach + 1)), base(k.size());
    double sum = 0.0, second = 0.0, fourth = 0.0;
    for (int i = -reach; i <= reach; ++i) {
        const double g = detExp(-0.5 * i * i / (sigma * sigma));
        base[std::size_t(i + reach)] = g;
        sum += g;
        second += g * i * i;
        fourth += g * i * i * i * i;
    }
    const double variance = second / sum;
    for (int i = -reach; i <= reach; ++i) {
        const double g = base[std::size_t(i + reach)];
        double& out = k[std::size_t(i + reach)];
        if (order == 0) out = g / sum;
        if (order == 1) out = i * g / second;
        // Makes the sum 0, and the sum weighted with i^2 equal to 2.
        if (order == 2) out = 2.0 * (i * i - variance) * g / (fourth - variance * second);
    }
    return {k.begin(), k.end()};
}

// out(x) = sum over i of k(i) in(x + i) along one axis. Border values are repeated outside the grid.
void filterAxis(const FloatVolume& in, FloatVolume& out, int axis, const Kernel& kernel) {
    const Index3 n = in.grid.dims;
    const int reach = int(kernel.size() / 2);
    const std::size_t row = std::size_t(n.x), slice = row * std::size_t(n.y);
    parallelFor(processorCount(), n.z, [&](int z) {
        std::vector<float> line(row + 2 * std::size_t(reach));
        for (int y = 0; y < n.y; ++y) {
            const std::size_t at = std::size_t(z) * slice + std::size_t(y) * row;
            float* to = out.voxels.data() + at;
            std::fill(to, to + row, 0.0f);
            if (axis == 0) {
                const float* from = in.voxels.data() + at;
                std::fill(line.begin(), line.begin() + reach, from[0]);
                std::copy(from, from + row, line.begin() + reach);
                std::fill(line.end() - reach, line.end(), from[row - 1]);
            }
            for (int j = -reach; j <= reach; ++j) {
                const float weight = kernel[std::size_t(j + reach)];
                const float* from = line.data() + (j + reach);
                if (axis == 1)
                    from = in.voxels.data() + std::size_t(z) * slice +
                           std::size_t(std::clamp(y + j, 0, n.y - 1)) * row;
                if (axis == 2)
                    from = in.voxels.data() + std::size_t(std::clamp(z + j, 0, n.z - 1)) * slice +
                           std::size_t(y) * row;
                for (std::size_t x = 0; x < row; ++x)
                    to[x] += weight * from[x];
            }
        }
    });
}

// Upper triangle: xx, yy, zz, xy, xz, yz.
using Hessian = std::array<FloatVolume, 6>;

Hessian computeHessian(const FloatVolume& image, const std::array<double, 3>& sigma) {
    Kernel k[3][3];
    for (int axis = 0; axis < 3; ++axis)
        for (int order = 0; order < 3; ++order)
            k[axis][order] = gaussianKernel(sigma[std::size_t(axis)], order);
    const Grid& g = image.grid;
    Hessian h;
    for (FloatVolume& v : h)
        v = FloatVolume(g);
    FloatVolume a(g), b(g);
    const auto along = [&](const FloatVolume& from, FloatVolume& to, int axis, int order) {
        filterAxis(from, to, axis, k[axis][order]);
    };
    along(image, a, 2, 0);
    along(a, b, 1, 0), along(b, h[0], 0, 2);
    along(a, b, 1, 2), along(b, h[1], 0, 0);
    along(a, b, 1, 1), along(b, h[3], 0, 1);
    along(image, a, 2, 1);
    along(a, b, 1, 0), along(b, h[4], 0, 1);
    along(a, b, 1, 1), along(b, h[5], 0, 0);
    along(image, a, 2, 2);
    along(a, b, 1, 0), along(b, h[2], 0, 0);
    return h;
}

struct Eigenvalues {
    float largest, middle, smallest;
};

// Eigenvalues of a symmetric matrix in closed form: Smith, "Eigenvalues of a symmetric 3 x 3 matrix", Comm.
// ACM 4, 1961.
Eigenvalues eigenvalues(float xx, float yy, float zz, float xy, float xz, float yz) {
    const float mean = (xx + yy + zz) / 3.0f;
    const float a = xx - mean, b = yy - mean, c = zz - mean;
    const float p = std::sqrt((a * a + b * b + c * c + 2.0f * (xy * xy + xz * xz + yz * yz)) / 6.0f);
    if (!(p > 0.0f)) return {mean, mean, mean};
    const float det = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
    const float half = std::clamp(det / (2.0f * p * p * p), -1.0f, 1.0f);
    const float angle = std::acos(half) / 3.0f;
    constexpr float kThird = 2.0943951f;  // of a full turn
    const float largest = mean + 2.0f * p * std::cos(angle);
    const float smallest = mean + 2.0f * p * std::cos(angle + kThird);
    return {largest, 3.0f * mean - largest - smallest, smallest};
}

float lineMeasure(const Eigenvalues& l) {
    if (l.middle >= 0.0f) return 0.0f;
    const float along = l.largest <= 0.0f ? l.largest : -kAlpha * l.largest;
    return std::max(0.0f, along - l.middle);
}

}  // namespace

Mask uncropped(const Mask& part, const VoxelBox& box, const Grid& whole) {
    Mask out(whole);
    paste(part, box.low, out);
    return out;
}

FloatVolume tubeResponse(const FloatVolume& image, const Mask& within, double sigma_m, TubeKind kind) {
    const Grid& g = image.grid;
    std::array<double, 3> sigma;
    for (int axis = 0; axis < 3; ++axis)
        sigma[std::size_t(axis)] = std::max(kMinSigma, sigma_m / g.spacing_m[axis]);
    const Hessian h = computeHessian(image, sigma);
    // Derivatives are per voxel: one factor contains sigma^2 and the axes' spacings.
    const auto scale = [&](int i, int j) {
        return float(sigma[std::size_t(i)] * sigma[std::size_t(j)]) *
               (kind == TubeKind::bright ? 1.0f : -1.0f);
    };
    const float sxx = scale(0, 0), syy = scale(1, 1), szz = scale(2, 2);
    const float sxy = scale(0, 1), sxz = scale(0, 2), syz = scale(1, 2);
    FloatVolume response(g);
    parallelVoxels(g, [&](const Index3& i) {
        if (within[i])
            response[i] = lineMeasure(eigenvalues(sxx * h[0][i], syy * h[1][i], szz * h[2][i], sxy * h[3][i],
                                                  sxz * h[4][i], syz * h[5][i]));
    });
    return response;
}

FloatVolume gaussian(const FloatVolume& image, double sigma_m) {
    FloatVolume a(image.grid), b(image.grid);
    const auto kernel = [&](int axis) {
        return gaussianKernel(std::max(kMinSigma, sigma_m / image.grid.spacing_m[axis]), 0);
    };
    filterAxis(image, a, 0, kernel(0));
    filterAxis(a, b, 1, kernel(1));
    filterAxis(b, a, 2, kernel(2));
    return a;
}

}  // namespace stylet::modeller
