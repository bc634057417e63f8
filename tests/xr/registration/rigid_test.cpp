// Tests with known results: a known transform is recovered, and the error at a target matches Fitzpatrick's
// formula.
#include "xr/registration/rigid.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Random;

const std::vector<Vec3> kCorners = chooseTouchPlaces(Cube{}, 8);

std::vector<Vec3> moved(const Pose& a_from_b, double scale, const std::vector<Vec3>& points) {
    std::vector<Vec3> result;
    for (const Vec3& p : points)
        result.push_back(a_from_b * (scale * p));
    return result;
}

TEST(Rigid, AKnownTransformAndScaleAreRecovered) {
    Random random(1);
    for (int i = 0; i < 50; ++i) {
        const Pose truth{random.turn(3.1), random.inCube(2.0)};
        const double scale = random.between(0.9, 1.1);
        const auto fit = fitRigid(moved(truth, scale, kCorners), kCorners, true);
        ASSERT_TRUE(fit) << fit.why_not;
        EXPECT_LT(angleBetween(fit->a_from_b.rotation, truth.rotation), 1e-9);
        EXPECT_LT(glm::distance(fit->a_from_b.position_m, truth.position_m), 1e-12);
        EXPECT_NEAR(fit->scale, scale, 1e-12);
        EXPECT_LT(fit->fre_m, 1e-12);
    }
}

// Points in a plane still determine a rigid transform. The result must never be a mirror image.
TEST(Rigid, PointsInAPlaneAreNotMirrored) {
    const std::vector<Vec3> square = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
    const Pose truth{glm::angleAxis(2.0, glm::normalize(Vec3(1, 2, 3))), Vec3(0.1, 0.2, 0.3)};
    const auto fit = fitRigid(moved(truth, 1.0, square), square, false);
    ASSERT_TRUE(fit) << fit.why_not;
    EXPECT_LT(angleBetween(fit->a_from_b.rotation, truth.rotation), 1e-9);
    EXPECT_EQ(fit->scale, 1.0);
}

TEST(Rigid, DegenerateInputIsRefusedWithAReason) {
    const auto refuse = [](std::vector<Vec3> a, std::vector<Vec3> b, const std::string& words) {
        const auto fit = fitRigid(a, b, true);
        EXPECT_FALSE(fit);
        EXPECT_NE(fit.why_not.find(words), std::string::npos) << fit.why_not;
    };
    const std::vector<Vec3> line = {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}, {0.3, 0, 0}};
    refuse({}, {}, "Three points");
    refuse({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, 0, 0}}, "Three points");
    refuse(line, kCorners, "different numbers");
    refuse(line, line, "on a line");
    refuse(std::vector<Vec3>(5, Vec3(0.3)), std::vector<Vec3>(5, Vec3(0.1)), "one place");
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        std::vector<Vec3> broken = kCorners;
        broken[3].y = bad;
        refuse(broken, kCorners, "not a number");
        refuse(kCorners, broken, "not a number");
    }
}

// Eight corners of a cube: about every axis, f^2 is twice the squared half edge, and so is d^2 at a corner.
TEST(Rigid, TheTargetErrorMatchesFitzpatricksFormula) {
    EXPECT_NEAR(expectedTre_m(kCorners, 0.001, Vec3(0.0)), 0.001 / std::sqrt(8.0), 1e-12);
    EXPECT_NEAR(expectedTre_m(kCorners, 0.001, kCorners[0]), 0.001 * std::sqrt(2.0 / 8.0), 1e-12);
    const CubeError in = expectedTreInCube(Cube{}, kCorners, 0.001);
    EXPECT_NEAR(in.mean_m, 0.001 * std::sqrt((1.0 + 1.0 / 3.0) / 8.0), 1e-12);
    EXPECT_NEAR(in.worst_m, 0.0005, 1e-12);
    EXPECT_NEAR(expectedFre_m(8, 0.001), 0.001 * std::sqrt(0.75), 1e-15);
    EXPECT_EQ(expectedTre_m({{Vec3(0), Vec3(1, 0, 0), Vec3(2, 0, 0)}}, 0.001, Vec3(0)),
              std::numeric_limits<double>::infinity());
}

// Also for irregular points, the closed form of the mean over the cube matches an average over samples.
TEST(Rigid, TheMeanOverTheCubeMatchesSampledPoints) {
    Random random(5);
    std::vector<Vec3> points;
    for (int i = 0; i < 6; ++i)
        points.push_back(random.inCube(0.05));
    const Cube cube{{0.02, -0.01, 0.03}, 0.04};
    double squares = 0.0, worst = 0.0;
    constexpr int kMany = 20'000;
    for (int i = 0; i < kMany; ++i) {
        const double tre_m = expectedTre_m(points, 0.001, cube.centre_m + random.inCube(cube.half_m));
        squares += tre_m * tre_m / kMany;
        worst = std::max(worst, tre_m);
    }
    const CubeError in = expectedTreInCube(cube, points, 0.001);
    EXPECT_NEAR(in.mean_m, std::sqrt(squares), 0.01 * in.mean_m);
    EXPECT_GE(in.worst_m, worst);
    EXPECT_LT(in.worst_m, 1.1 * worst);
}

}  // namespace
}  // namespace stylet::xr::registration
