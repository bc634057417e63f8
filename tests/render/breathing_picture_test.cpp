// The picture breathes as the forces do: a ball inside the cavity is seen where
// patient::deformedFromReference puts it.
#include <gtest/gtest.h>

#include <cmath>

#include "render/deform.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

// What deform.glsl computes, in double precision.
Vec3 twinOfShader(const BreathRows& breath, const Vec3& p) {
    const auto rowAt = [&](double z) {
        const double r =
            std::clamp((z - breath.z_begin_m) / breath.dz_m, 0.0, double(breath.rows.size() - 1));
        const std::size_t i = std::min(std::size_t(r), breath.rows.size() - 2);
        const double f = r - double(i);
        const auto mix = [&](const glm::vec4& a, const glm::vec4& b) {
            return glm::mix(glm::dvec4(a), glm::dvec4(b), f);
        };
        return std::pair(mix(breath.rows[i].ellipse, breath.rows[i + 1].ellipse),
                         mix(breath.rows[i].z, breath.rows[i + 1].z));
    };
    const double row = (p.z - breath.z_begin_m) / breath.dz_m;
    if (row <= 0.0 || row >= double(breath.rows.size() - 1)) return p;
    const auto [ellipse, zs] = rowAt(p.z);
    const double u = (p.x - ellipse.x) / ellipse.z, w = (p.y - ellipse.y) / ellipse.w, rho = std::hypot(u, w);
    if (rho >= breath.fade_rho) return p;
    double z = zs.x;
    if (rho >= 1.0) {
        const double s = (breath.fade_rho - rho) / (breath.fade_rho - 1.0);
        z = glm::mix(p.z, zs.y, s * s * (3.0 - 2.0 * s));
    }
    const auto there = rowAt(z).first;
    return {there.x + u * there.z, there.y + w * there.w, z};
}

TEST(BreathRows, FollowTheModelInsideAndOutside) {
    const patient::Package package = test::makeTrunk(0.01);
    const patient::BreathingModel& model = package.breathing;
    for (const double v : {0.0, 0.25, 1.0}) {
        const patient::Surrogate now{v, 0.0};
        const BreathRows rows = breathRows(model, now);
        double worst_inside = 0.0, worst_outside = 0.0;
        for (double x = -0.15; x <= 0.15; x += 0.0107)
            for (double y = -0.10; y <= 0.10; y += 0.0113)
                for (double z = -0.119; z <= 0.119; z += 0.0037) {
                    const Vec3 p(x, y, z);
                    const double rho = patient::cavityRho(model, p);
                    if (std::fabs(rho - 1.0) < 0.01) continue;  // the two sides slide on each other there
                    const double error =
                        glm::length(twinOfShader(rows, p) - referenceFromDeformed(model, now, p));
                    (rho < 1.0 ? worst_inside : worst_outside) =
                        std::max(rho < 1.0 ? worst_inside : worst_outside, error);
                }
        EXPECT_LT(worst_inside, 1e-4) << v;
        EXPECT_LT(worst_outside, 3e-4)
            << v;  // the faded share is applied to the displacement, not to the velocity
    }
}

TEST(BreathingPicture, ABallInTheCavityMovesAsTheModelSays) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    patient::Package package = test::makeBall(patient::Tissue::bone, 0.015, 0.045, 0.002);
    patient::BreathingModel& model = package.breathing;
    model.a1_m = -0.020;
    model.z_low_m = -0.058, model.z_full_low_m = -0.045, model.z_full_high_m = 0.025, model.z_high_m = 0.058;
    model.cavity = {{-0.06, 0.0, 0.0, 0.05, 0.05}, {0.06, 0.0, 0.0, 0.05, 0.05}};
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
    const auto seenAt = [&](double v) {
        scene.breath = {v, 0.0};
        return test::findBlob(renderer.drawToImages(scene, eyes, size, size)[0],
                              [](int r, int g, int b) { return r > 130 && g > 110 && b > 90; });
    };
    const test::Blob rest = seenAt(0.0);
    ASSERT_GT(rest.pixels, 500u);
    const double pixels_per_m = size / (2.0 * std::tan(double(half_angle)) * distance);
    for (const double v : {0.3, 1.0}) {
        const test::Blob moved = seenAt(v);
        const double travel = deformedFromReference(model, {v, 0.0}, Vec3(0.0)).z;
        EXPECT_NEAR(travel, -0.020 * v, 1e-6);
        // The patient's head is up in the picture: caudal is down, and rows grow downwards.
        EXPECT_NEAR(moved.y - rest.y, -travel * pixels_per_m, 1.0) << v;
        EXPECT_NEAR(moved.x - rest.x, 0.0, 1.0) << v;
        EXPECT_NEAR(double(moved.pixels), double(rest.pixels), 0.06 * double(rest.pixels)) << v;
    }
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

}  // namespace
}  // namespace stylet::render
