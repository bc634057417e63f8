#include "app/modeller/image/vector_field.h"

#include <algorithm>
#include <cmath>

namespace stylet::modeller {

namespace {

constexpr int kSquarings = 6;
constexpr int kLogSteps = 8;
constexpr double kLogTolerance_m = 2e-5;

// The eight voxels around p and their weights, clamped to the grid.
struct Corners {
    std::size_t at[8];
    float weight[8];
    Corners(const Grid& g, const Vec3& p_m) {
        const Vec3 v = g.toVoxels(p_m);
        int low[3], high[3];
        float f[3];
        for (int d = 0; d < 3; ++d) {
            const double x = std::clamp(v[d], 0.0, double(g.dims[d] - 1));
            low[d] = int(x);
            high[d] = std::min(low[d] + 1, g.dims[d] - 1);
            f[d] = float(x - low[d]);
        }
        for (int c = 0; c < 8; ++c) {
            const bool up[3] = {(c & 1) != 0, (c & 2) != 0, (c & 4) != 0};
            at[c] = g.offset({up[0] ? high[0] : low[0], up[1] ? high[1] : low[1], up[2] ? high[2] : low[2]});
            weight[c] = 1.0f;
            for (int d = 0; d < 3; ++d)
                weight[c] *= up[d] ? f[d] : 1.0f - f[d];
        }
    }
};

// The displacement of moving a point by `b` and then by `a`: b(p) + a(p + b(p)), sampled on b's grid.
// In the notation of Arsigny et al.: (id + a) o (id + b) - id.
VectorField composed(const VectorField& a, const VectorField& b) {
    VectorField out(b.grid);
    parallelVoxels(b.grid, [&](const Index3& i) {
        const Vec3 step(b[i]);
        out[i] = glm::vec3(step + vectorAt(a, b.grid.centre(i) + step));
    });
    return out;
}

VectorField scaled(VectorField field, float by) {
    for (glm::vec3& v : field.voxels)
        v *= by;
    return field;
}

}  // namespace

Vec3 vectorAt(const VectorField& field, const Vec3& p_m) {
    const Corners corners(field.grid, p_m);
    glm::vec3 sum(0.0f);
    for (int c = 0; c < 8; ++c)
        sum += corners.weight[c] * field.voxels[corners.at[c]];
    return Vec3(sum);
}

float valueAt(const FloatVolume& image, const Vec3& p_m, float outside) {
    const Vec3 v = image.grid.toVoxels(p_m);
    for (int d = 0; d < 3; ++d)
        if (!(v[d] >= -0.5 && v[d] <= double(image.grid.dims[d]) - 0.5)) return outside;
    const Corners corners(image.grid, p_m);
    float sum = 0.0f;
    for (int c = 0; c < 8; ++c)
        sum += corners.weight[c] * image.voxels[corners.at[c]];
    return sum;
}

VectorField exponential(const VectorField& velocity) {
    VectorField u = scaled(velocity, 1.0f / float(1 << kSquarings));
    for (int i = 0; i < kSquarings; ++i)
        u = composed(u, u);
    return u;
}

VectorField logarithm(const VectorField& displacement, double& error_m) {
    VectorField v = displacement;
    for (int step = 0;; ++step) {
        const VectorField mismatch = composed(displacement, exponential(scaled(v, -1.0f)));
        float largest = 0.0f;
        for (const glm::vec3& d : mismatch.voxels)
            largest = std::max(largest, d.x * d.x + d.y * d.y + d.z * d.z);
        error_m = std::sqrt(double(largest));
        if (step == kLogSteps || error_m < kLogTolerance_m) return v;
        for (std::size_t i = 0; i < v.voxels.size(); ++i)
            v.voxels[i] += mismatch.voxels[i];
    }
}

FloatVolume warped(const FloatVolume& image, const VectorField& displacement, float outside) {
    FloatVolume out(image.grid);
    parallelVoxels(image.grid, [&](const Index3& i) {
        const Vec3 p = image.grid.centre(i);
        out[i] = valueAt(image, p + vectorAt(displacement, p), outside);
    });
    return out;
}

}  // namespace stylet::modeller
