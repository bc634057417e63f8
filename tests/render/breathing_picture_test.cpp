// The picture must breathe like the forces: a ball inside the cavity must appear where
// patient::deformedFromReference puts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/smoothstep.h"
#include "render/volume/deform.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/volume/deform_points.h"
#include "tests/support/motion.h"

namespace stylet::render {
namespace {

// HZ-TEACH-15
TEST(DeformTables, AgreeWithThePointFunctions) {
    const patient::Package package = test::makeTrunk(0.01);
    const patient::MotionModel& model = package.motion;
    for (const patient::Surrogate now :
         {patient::Surrogate{0.0, 0.0}, patient::Surrogate{0.25, 1.0}, patient::Surrogate{1.0, 0.0}}) {
        const DeformTables tables = deformTables(model, now);
        std::vector<double> errors_m;
        for (double x = -0.15; x <= 0.15; x += 0.0067)
            for (double y = -0.10; y <= 0.10; y += 0.0073)
                for (double z = -0.119; z <= 0.119; z += 0.0053) {
                    const Vec3 p(x, y, z);
                    // The two sides slide on each other here.
                    if (std::fabs(patient::cavityLevel_m(model, now, p)) < 3e-4) continue;
                    const Vec3 off = referenceFromTables(tables, p) - referenceFromDeformed(model, now, p);
                    errors_m.push_back(glm::length(off));
                }
        std::sort(errors_m.begin(), errors_m.end());
        EXPECT_LT(errors_m[std::size_t(0.99 * double(errors_m.size()))], 1e-4) << now.v;
        EXPECT_LT(errors_m.back(), 4e-4) << now.v;
    }
}

// Compares tables for the visible region only with tables for the whole box.
TEST(DeformTables, BodyRegionMatchesTheWholeBox) {
    const patient::Package package = test::makeTrunk(0.004);
    const patient::Patient patient(package);
    DeformTableBuilder near(package.motion, {}, &patient), all(package.motion, {}, nullptr);
    EXPECT_LT(near.computedNodes(), all.computedNodes());
    Workers workers(2);
    for (const patient::Surrogate now : {patient::Surrogate{0.7, 1.0}, patient::Surrogate{1.5, -4.0}}) {
        near.compute(now, workers), all.compute(now, workers);
        int asked = 0;
        double reach_m = 0.0;
        for (double x = -0.17; x <= 0.17; x += 0.0061)
            for (double y = -0.12; y <= 0.12; y += 0.0057)
                for (double z = -0.13; z <= 0.13; z += 0.0067) {
                    const Vec3 p(x, y, z), reference_m = referenceFromTables(all.tables(), p);
                    reach_m = std::max(reach_m, glm::length(reference_m - p));
                    if (!test::inBody(package, now, p)) continue;
                    ++asked;
                    EXPECT_LT(glm::length(referenceFromTables(near.tables(), p) - reference_m), 1e-6);
                }
        EXPECT_GT(asked, 5000);
        EXPECT_LE(reach_m, all.reach_m());
    }
}

TEST(DeformTables, PortableMatchesSimd) {
    const patient::Package package = test::makeTrunk(0.01);
    const patient::Surrogate now{0.9, 0.5};
    const DeformTables wide = deformTables(package.motion, now);
    const DeformTables portable = deformTables(package.motion, now, {.portable = true});
    double max_m = 0.0;
    for (std::size_t i = 0; i < wide.inside.size(); ++i) {
        max_m = std::max(max_m, double(glm::length(glm::vec3(wide.inside[i] - portable.inside[i]))));
        max_m = std::max(max_m, double(glm::length(glm::vec3(wide.outside[i] - portable.outside[i]))));
    }
    EXPECT_LT(max_m, 2e-6);
}

// Includes what the shader adds: half-precision floats and the device's texture filter.
// HZ-TEACH-15
TEST(DeformTables, GpuLookUpMatchesThePointFunctions) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    const patient::Package package = test::makeTrunk(0.01);
    const patient::Patient patient(package);
    Gpu gpu({.validation = true});
    DeformedPatient deformed(gpu, patient);
    const patient::Surrogate now{0.9, 0.5};
    deformed.breathe(now, false);
    std::vector<Vec3> points_m;
    for (double x = -0.15; x <= 0.15; x += 0.0083)
        for (double y = -0.10; y <= 0.10; y += 0.0079)
            for (double z = -0.119; z <= 0.119; z += 0.0067)
                if (const Vec3 p(x, y, z); std::fabs(patient::cavityLevel_m(package.motion, now, p)) > 3e-4 &&
                                           test::inBody(package, now, p))
                    points_m.push_back(p);
    const std::vector<Vec3> found_m = test::referenceOnGpu(gpu, deformed, points_m);
    ASSERT_EQ(found_m.size(), points_m.size());
    std::vector<double> errors_m;
    double max_m = 0.0;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Vec3 truth_m = referenceFromDeformed(package.motion, now, points_m[i]);
        errors_m.push_back(glm::length(found_m[i] - truth_m));
        max_m = std::max(max_m, glm::length(truth_m - points_m[i]));
    }
    std::sort(errors_m.begin(), errors_m.end());
    EXPECT_GT(max_m, 0.010);
    EXPECT_LT(errors_m[std::size_t(0.99 * double(errors_m.size()))], 1e-4);
    EXPECT_LT(errors_m.back(), 4e-4);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

TEST(DeformTables, AreZeroWithoutMotion) {
    const DeformTables tables = deformTables({}, {1.0, 0.0});
    EXPECT_EQ(referenceFromTables(tables, {0.1, -0.2, 3.0}), Vec3(0.1, -0.2, 3.0));
}

// HZ-TEACH-15
TEST(BreathingPicture, BallInTheCavityFollowsTheMotionModel) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    patient::Package package = test::makeBall(patient::Tissue::bone, 0.015, 0.045, 0.002);
    package.motion = test::makeMotion(Vec3(0.08), 0.005, [](const Vec3& p) {
        test::MotionPoint q;
        q.slide_a1_m.z = -0.020 * smoothStep(-0.075, -0.045, p.z) * smoothStep(0.075, 0.025, p.z);
        q.level_m = std::hypot(p.x, p.y) - 0.05;
        return q;
    });
    const patient::MotionModel& model = package.motion;
    const patient::Patient patient(package);
    Gpu gpu({.validation = true});
    Renderer renderer(gpu, {}, test::assetsFolder());
    renderer.setPatient(patient);
    RenderScene scene;
    scene.look = Look::closed;
    scene.table = false;
    scene.stage_from_patient = {glm::angleAxis(-std::acos(0.0), Vec3(1, 0, 0)), Vec3(0, 1, 0)};  // head up
    const double distance = 0.4;
    const float half_angle = 0.2f;
    const auto eyes = test::stereo(test::lookAt(Vec3(0, 1, distance), Vec3(0, 1, 0), half_angle), 0.0);
    const std::uint32_t size = 256;
    const auto findBallAt = [&](double v) {
        scene.breath = {v, 0.0};
        return test::findBlob(renderer.drawToImages(scene, eyes, size, size)[0],
                              [](int r, int g, int b) { return r > 130 && g > 110 && b > 90; });
    };
    const test::Blob rest = findBallAt(0.0);
    ASSERT_GT(rest.pixels, 500u);
    const double pixels_per_m = size / (2.0 * std::tan(double(half_angle)) * distance);
    for (const double v : {0.3, 1.0}) {
        const test::Blob moved = findBallAt(v);
        const double travel = deformedFromReference(model, {v, 0.0}, Vec3(0.0)).z;
        EXPECT_NEAR(travel, -0.020 * v, 1e-6);
        // The patient's head is up in the picture: caudal motion is downward, and rows count downward.
        EXPECT_NEAR(moved.y - rest.y, -travel * pixels_per_m, 1.0) << v;
        EXPECT_NEAR(moved.x - rest.x, 0.0, 1.0) << v;
        EXPECT_NEAR(double(moved.pixels), double(rest.pixels), 0.06 * double(rest.pixels)) << v;
    }
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

}  // namespace
}  // namespace stylet::render
