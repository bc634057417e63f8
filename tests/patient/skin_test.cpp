#include "patient/package/skin.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/support/phantom.h"

namespace stylet::patient {
namespace {

// Soft tissue where `inside` returns true, surrounded by unlabelled air.
Package carve(const Grid& grid, const std::function<bool(const Vec3&)>& inside) {
    Package p;
    p.tissues = test::tissueDefaults().tissues;
    p.elasticity = test::tissueDefaults().elasticity;
    p.ct = CtVolume(grid, std::int16_t(-1000));
    p.labels = LabelVolume(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        if (inside(grid.centre(i))) p.ct[i] = 40;
    });
    return p;
}

Grid cube(double half_m, double spacing_m) {
    const int n = 2 * int(std::lround(half_m / spacing_m));
    return {Index3(n), Vec3(spacing_m), Vec3(-(0.5 * n - 0.5) * spacing_m)};
}

// Evenly distributed directions on a golden-angle spiral.
std::vector<Vec3> directions(int count) {
    std::vector<Vec3> list;
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / count, r = std::sqrt(1.0 - z * z), a = 2.399963229728653 * i;
        list.push_back({r * std::cos(a), r * std::sin(a), z});
    }
    return list;
}

class Ball : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Voxels, Ball, testing::Values(0.001, 0.0015, 0.002));

TEST_P(Ball, LevelIsAccurateToAFractionOfAVoxel) {
    constexpr double kRadius_m = 0.06;
    const Package package =
        carve(cube(0.08, GetParam()), [](const Vec3& p) { return glm::length(p) < kRadius_m; });
    const Skin skin = makeSkin(Patient(package), 2);
    for (const double level_m : {-0.015, -0.003, 0.0, 0.004}) {
        double worst_m = 0.0, worst_rad = 0.0;
        for (const Vec3& d : directions(3000)) {
            const SkinPoint s = skinAt(skin, (kRadius_m + level_m) * d);
            worst_m = std::max(worst_m, std::fabs(s.level_m - level_m));
            worst_rad = std::max(worst_rad, glm::length(s.normal - d));
        }
        EXPECT_LT(worst_m, (level_m < -0.01 ? 0.45 : 0.3) * GetParam()) << level_m;
        EXPECT_LT(worst_rad, 0.11) << level_m;
    }
}

TEST(Skin, FlatSkinIsExactAndNormalIsTheGradient) {
    const Package slabs = test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.030}}, 0.001);
    const Skin skin = makeSkin(Patient(slabs), 1);
    for (const double x_m : {-0.0123, -0.004, -0.0001, 0.0002, 0.0077, 0.0201}) {
        const SkinPoint s = skinAt(skin, {x_m, 0.0031, -0.0042});
        EXPECT_NEAR(s.level_m, -x_m, 1e-6);
        EXPECT_NEAR(glm::length(s.normal - Vec3(-1.0, 0.0, 0.0)), 0.0, 1e-5);
    }
    const Package ball = carve(cube(0.03, 0.001), [](const Vec3& p) { return glm::length(p) < 0.02; });
    const Skin round = makeSkin(Patient(ball), 1);
    constexpr double kStep_m = 1e-6;
    for (const Vec3& d : directions(50)) {
        const Vec3 p = 0.0193 * d;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 high = p, low = p;
            high[axis] += kStep_m, low[axis] -= kStep_m;
            const double slope = (skinAt(round, high).level_m - skinAt(round, low).level_m) / (2.0 * kStep_m);
            EXPECT_NEAR(skinAt(round, p).normal[axis], slope, 1e-5);
        }
    }
}

TEST(Skin, LungAndImageBorderAreNotSkin) {
    // A tube of tissue along z. Both the tube and the cavity in it extend beyond the image.
    const Package package = carve(cube(0.05, 0.001), [](const Vec3& p) {
        const double r = std::sqrt(p.x * p.x + p.y * p.y);
        return r < 0.04 && r > 0.02;
    });
    const Skin skin = makeSkin(Patient(package), 1);
    EXPECT_LT(skinAt(skin, {0.0, 0.0, 0.0}).level_m, -0.035);
    for (const double z_m : {-0.049, -0.03, 0.0, 0.049})
        EXPECT_NEAR(skinAt(skin, {0.038, 0.0, z_m}).level_m, -0.002, 0.0003);
    // Outside the image: the distance to the image plus the level at its edge.
    EXPECT_NEAR(skinAt(skin, {0.069, 0.0, 0.0}).level_m, 0.029, 0.0008);
}

TEST(Skin, NearestPointLiesOnTheSkin) {
    const Package ball = carve(cube(0.08, 0.002), [](const Vec3& p) { return glm::length(p) < 0.06; });
    const Skin skin = makeSkin(Patient(ball), 1);
    for (const Vec3& d : directions(200))
        for (const double from_m : {0.035, 0.055, 0.06, 0.07}) {
            const Vec3 foot = nearestSkinPoint(skin, from_m * d);
            EXPECT_NEAR(skinAt(skin, foot).level_m, 0.0, 2e-6);
            EXPECT_LT(glm::length(foot - 0.06 * d), 0.0015);
        }
}

TEST(Skin, IsIndependentOfThreads) {
    const Package ball = carve(cube(0.04, 0.0015), [](const Vec3& p) { return glm::length(p) < 0.03; });
    EXPECT_EQ(makeSkin(Patient(ball), 1).level_m.voxels, makeSkin(Patient(ball), 3).level_m.voxels);
}

TEST(Skin, AcceptsDegenerateImages) {
    for (const bool full : {false, true}) {
        const Package p = carve({{1, 2, 2}, Vec3(0.01), Vec3(0.0)}, [&](const Vec3&) { return full; });
        const Skin skin = makeSkin(Patient(p), 1);
        EXPECT_EQ(skinAt(skin, Vec3(0.001)).level_m < 0.0, full);
    }
    const Package slabs = test::makeSlabs({{Tissue::soft, 0.010}}, 0.001);
    const double nan = std::nan("");
    EXPECT_GT(skinAt(makeSkin(Patient(slabs), 1), {1e9, -1e9, 0.0}).level_m, 1e8);
    EXPECT_FALSE(skinAt(makeSkin(Patient(slabs), 1), {nan, 0.0, 0.0}).level_m < 0.0);
}

}  // namespace
}  // namespace stylet::patient
