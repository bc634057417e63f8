#include "app/modeller/image/vector_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::modeller {
namespace {

Grid cubeAboutOrigin(int n) {
    return {Index3(n), Vec3(0.002), Vec3(-0.001 * (n - 1))};
}

template <typename At>
VectorField makeField(const Grid& grid, const At& at) {
    VectorField field(grid);
    forEachVoxel(grid, [&](const Index3& i) { field[i] = glm::vec3(at(grid.centre(i))); });
    return field;
}

// Falls smoothly to zero at 25 mm from the origin, so that the grid's border has no effect.
double bump(const Vec3& p) {
    const double r2 = (p.x * p.x + p.y * p.y + p.z * p.z) / (0.025 * 0.025);
    return r2 < 1.0 ? (1.0 - r2) * (1.0 - r2) : 0.0;
}

TEST(VectorField, ExponentialOfAConstantIsTheConstant) {
    const VectorField u =
        exponential(makeField(cubeAboutOrigin(12), [](const Vec3&) { return Vec3(0.001, -0.002, 0.003); }));
    for (const glm::vec3& v : u.voxels) {
        ASSERT_NEAR(v.x, 0.001f, 1e-8f);
        ASSERT_NEAR(v.z, 0.003f, 1e-8f);
    }
}

TEST(VectorField, ExponentialOfALinearFieldMatchesClosedForm) {
    const double rate = 0.2;
    const VectorField u =
        exponential(makeField(cubeAboutOrigin(31), [&](const Vec3& p) { return rate * p; }));
    for (const Index3& i : {Index3(15, 15, 15), Index3(10, 18, 15), Index3(20, 12, 8)}) {
        const Vec3 p = u.grid.centre(i);
        // exponential() scales the field by 1/64 and squares six times: (1 + rate/64)^64. This is less than
        // e^rate by a relative error of rate^2 / 128.
        ASSERT_NEAR(u[i].x, (std::exp(rate) - 1.0) * p.x, 5e-4 * std::fabs(p.x) + 1e-8);
        ASSERT_NEAR(u[i].z, (std::exp(rate) - 1.0) * p.z, 5e-4 * std::fabs(p.z) + 1e-8);
    }
}

TEST(VectorField, LogarithmInvertsTheExponential) {
    const VectorField v = makeField(cubeAboutOrigin(31), [](const Vec3& p) {
        return bump(p) * Vec3(0.004 + 0.1 * p.y, -0.2 * p.x, -0.009);
    });
    double error_m = 1.0;
    const VectorField back = logarithm(exponential(v), error_m);
    EXPECT_LT(error_m, 1e-4);
    double worst_m = 0.0, max_m = 0.0;
    for (std::size_t i = 0; i < v.voxels.size(); ++i) {
        const Vec3 off(back.voxels[i] - v.voxels[i]);
        worst_m = std::max(worst_m, std::sqrt(off.x * off.x + off.y * off.y + off.z * off.z));
        max_m = std::max(max_m, std::fabs(double(v.voxels[i].z)));
    }
    EXPECT_GT(max_m, 0.008);
    EXPECT_LT(worst_m, 4e-4);  // from linear interpolation between voxels of 2 mm
}

TEST(VectorField, WarpSamplesAtTheDisplacedPosition) {
    FloatVolume ramp(cubeAboutOrigin(20));
    forEachVoxel(ramp.grid, [&](const Index3& i) { ramp[i] = float(10 * i.z + i.x); });
    const VectorField shift =
        makeField(cubeAboutOrigin(20), [](const Vec3&) { return Vec3(0.0, 0.0, 0.003); });
    const FloatVolume moved = warped(ramp, shift, -1000.0f);
    EXPECT_NEAR((moved[{4, 5, 6}]), 10.0f * 7.5f + 4.0f, 1e-3f);
    EXPECT_EQ((moved[{4, 5, 19}]), -1000.0f);
}

}  // namespace
}  // namespace stylet::modeller
