#include "app/modeller/segmentation/tubes.h"

#include <gtest/gtest.h>

#include "tests/app/modeller/segmentation/liver_phantom.h"

namespace stylet::modeller {
namespace {

using test::cube;

constexpr int kSide = 41;
const Vec3 kTubeMiddle(0.020);
constexpr double kContrast = 100.0;

// Image of a bright shape. `distance` returns the distance of a point from its axis, plane or centre. A voxel
// at the border gets the share of its volume that lies within `radius_m`.
template <typename Distance>
FloatVolume paintVolume(double radius_m, const Distance& distance) {
    FloatVolume v(cube(kSide));
    forEachVoxel(v.grid, [&](const Index3& i) {
        v[i] =
            float(kContrast * test::coveredShare(distance(v.grid.centre(i) - kTubeMiddle), radius_m, 0.001));
    });
    return v;
}

FloatVolume cylinder(double radius_m, const Vec3& direction) {
    const Vec3 d = glm::normalize(direction);
    return paintVolume(radius_m, [&](const Vec3& p) { return glm::length(p - glm::dot(p, d) * d); });
}

float responseAtCentre(const FloatVolume& image, double sigma_m, TubeKind kind = TubeKind::bright) {
    Mask within(image.grid);
    within[Index3(kSide / 2)] = 1;
    return tubeResponse(image, within, sigma_m, kind)[Index3(kSide / 2)];
}

double closedForm(double radius_m, double sigma_m) {
    const double q = radius_m * radius_m / (2.0 * sigma_m * sigma_m);
    return kContrast * q * std::exp(-q);
}

TEST(Tubes, CylinderResponseMatchesClosedForm) {
    constexpr double kRadius_m = 0.003;
    const FloatVolume image = cylinder(kRadius_m, {0, 0, 1});
    float best = 0.0f;
    double best_sigma_m = 0.0;
    for (double sigma_m = 0.0011; sigma_m < 0.0045; sigma_m += 0.0002) {
        const float r = responseAtCentre(image, sigma_m);
        EXPECT_NEAR(r, closedForm(kRadius_m, sigma_m), 2.0) << sigma_m;
        if (r > best) best = r, best_sigma_m = sigma_m;
    }
    EXPECT_NEAR(best_sigma_m, kRadius_m / std::sqrt(2.0), 0.00021);
    EXPECT_NEAR(best, kContrast / std::exp(1.0), 1.5);
}

TEST(Tubes, ResponseIsRotationInvariant) {
    constexpr double kRadius_m = 0.0025, kSigma_m = kRadius_m / 1.41421356;
    for (const Vec3& direction :
         {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(0, 1, -1), Vec3(1, 1, 1), Vec3(1, -2, 3)})
        EXPECT_NEAR(responseAtCentre(cylinder(kRadius_m, direction), kSigma_m), kContrast / std::exp(1.0),
                    2.0);
}

TEST(Tubes, PlatesAndBallsGiveNoResponse) {
    const FloatVolume plate =
        paintVolume(0.003, [](const Vec3& p) { return std::abs(p.x + p.y) / std::sqrt(2.0); });
    const FloatVolume ball = paintVolume(0.004, [](const Vec3& p) { return glm::length(p); });
    for (const double sigma_m : {0.0015, 0.002, 0.003}) {
        EXPECT_LT(responseAtCentre(plate, sigma_m), 0.5f);
        EXPECT_LT(responseAtCentre(ball, sigma_m), 0.5f);
    }
}

TEST(Tubes, DarkResponseIsTheNegatedBrightResponse) {
    FloatVolume image = cylinder(0.003, {0, 1, 1});
    const float bright = responseAtCentre(image, 0.002);
    EXPECT_EQ(responseAtCentre(image, 0.002, TubeKind::dark), 0.0f);
    for (float& v : image.voxels)
        v = 40.0f - v;
    EXPECT_NEAR(responseAtCentre(image, 0.002, TubeKind::dark), bright, 1e-3f);
    EXPECT_EQ(responseAtCentre(image, 0.002), 0.0f);
}

TEST(Tubes, ConstantImageGivesNoResponse) {
    const FloatVolume flat(cube(kSide), 70.0f);
    EXPECT_NEAR(gaussian(flat, 0.002)[Index3(0)], 70.0f, 1e-3f);
    EXPECT_NEAR(responseAtCentre(flat, 0.001), 0.0f, 1e-3f);
}

TEST(Tubes, CropAndUncropRoundTrip) {
    Mask mask(cube(12));
    EXPECT_TRUE(boxAround(mask, 3).empty());
    mask[{1, 5, 9}] = mask[{4, 5, 10}] = 1;
    const VoxelBox box = boxAround(mask, 2);
    EXPECT_EQ(box.low, Index3(0, 3, 7));
    EXPECT_EQ(box.high, Index3(6, 7, 11));
    const Mask part = cropped(mask, box);
    EXPECT_EQ(part.grid.dims, Index3(7, 5, 5));
    EXPECT_EQ((part[{1, 2, 2}]), 1);
    EXPECT_NEAR(part.grid.origin_m.z, 0.007, 1e-12);
    EXPECT_EQ(uncropped(part, box, mask.grid).voxels, mask.voxels);
}

}  // namespace
}  // namespace stylet::modeller
