#include "app/report/slices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/support/phantom.h"
#include "tests/support/temp_folder.h"

namespace stylet::report {
namespace {

using patient::Tissue;

NeedlePicture needleAt(const Vec3& tip_m, const Vec3& axis) {
    NeedlePicture needle;
    needle.tip_m = tip_m;
    needle.axis = glm::normalize(axis);
    needle.depth_m = 0.05;
    needle.title = "title";
    needle.caption = "caption";
    return needle;
}

TEST(SlicePlanes, ContainTheNeedleOrArePerpendicularToIt) {
    // Axes from the right flank, as in planned paths, and along z and y. Along z the "near axial" plane
    // cannot be axial.
    for (const Vec3& axis : {Vec3(-0.8, 0.3, 0.2), Vec3(-1, 0, 0), Vec3(0, 0, -1), Vec3(0, -1, 0)}) {
        const NeedlePicture needle = needleAt({0.1, 0.2, 0.3}, axis);
        const auto planes = slicePlanes(needle);
        for (const SlicePlane& plane : planes) {
            EXPECT_NEAR(glm::length(plane.right), 1.0, 1e-12) << plane.title;
            EXPECT_NEAR(glm::length(plane.down), 1.0, 1e-12) << plane.title;
            EXPECT_NEAR(glm::dot(plane.right, plane.down), 0.0, 1e-12) << plane.title;
            const Vec3 normal = glm::cross(plane.right, plane.down);
            EXPECT_NEAR(glm::dot(needle.tip_m - plane.centre_m, normal), 0.0, 1e-12) << plane.title;
            const double along = std::abs(glm::dot(normal, needle.axis));
            EXPECT_NEAR(along, &plane == &planes[2] ? 1.0 : 0.0, 1e-9) << plane.title;
        }
    }
}

// HZ-TEACH-04
TEST(SlicePlanes, HaveRadiologicalOrientation) {
    const auto planes = slicePlanes(needleAt({0, 0, 0}, {-1, 0, 0}));
    EXPECT_LT(glm::length(planes[0].right - Vec3(-1, 0, 0)), 1e-9);  // the patient's right is on the left
    EXPECT_LT(glm::length(planes[0].down - Vec3(0, -1, 0)), 1e-9);   // front on top
    EXPECT_LT(glm::length(planes[1].down - Vec3(0, 0, -1)), 1e-9);   // head on top
    // Viewed along the needle from the right flank, the patient's front is on the right.
    EXPECT_LT(glm::length(planes[2].right - Vec3(0, 1, 0)), 1e-9);
}

TEST(SamplePlane, ShowsWindowedCtAndTintsTheTarget) {
    const patient::Package package =
        test::makeSlabs({{Tissue::soft, 0.020}, {Tissue::duct, 0.010}, {Tissue::soft, 0.020}}, 0.001);
    const patient::Patient patient(package);
    SlicePlane plane;
    plane.centre_m = {0.025, 0.0, 0.0};
    plane.width_m = 0.030;
    std::array<std::size_t, 256> seen{};
    const int n = 60;
    const std::vector<std::uint8_t> rgb = samplePlane(patient, {}, plane, n, n, seen);
    ASSERT_EQ(rgb.size(), std::size_t(3 * n * n));
    const std::size_t duct = std::size_t(Tissue::duct), soft = std::size_t(Tissue::soft);
    EXPECT_EQ(seen[duct] + seen[soft], std::size_t(n * n));
    EXPECT_NEAR(double(seen[duct]) / (n * n), 1.0 / 3.0, 0.02);
    const auto pixel = [&](int i, int j) { return &rgb[std::size_t(3 * (j * n + i))]; };
    // Soft tissue is plain grey (40 HU in the window). The duct has the hue of its label.
    const double grey = 255.0 * (40.0 - kWindowLow_hu) / (kWindowHigh_hu - kWindowLow_hu);
    EXPECT_NEAR(pixel(3, n / 2)[0], grey, 1.0);
    EXPECT_EQ(pixel(3, n / 2)[0], pixel(3, n / 2)[2]);
    const std::uint8_t* middle = pixel(n / 2, n / 2);
    EXPECT_GT(int(middle[0]), int(middle[1]) + 40);
}

TEST(Slices, AreDrawn) {
    const patient::Package package = test::makeSlabs({{Tissue::soft, 0.020}, {Tissue::duct, 0.010}}, 0.002);
    const test::TempFolder folder;
    drawSlices(patient::Patient(package), needleAt({0.021, 0, 0}, {1, 0, 0}), folder / "slices.png");
    EXPECT_GT(std::filesystem::file_size(folder / "slices.png"), 5000u);
}

}  // namespace
}  // namespace stylet::report
