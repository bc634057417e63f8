// Tissue displaced by a tool must appear where patient::ToolDisplacement puts it, when pressed in and when
// pulled out.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "render/volume/deform.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/volume/deform_points.h"

namespace stylet::render {
namespace {

using patient::ToolContact;
using patient::ToolDisplacement;

constexpr std::uint32_t kToolPictureSize = 160;

// A trunk's right side, pressed in or pulled out along x.
struct Pressed {
    explicit Pressed(double moved_m, double v = 0.0) {
        patient::Surrogate breath{v, 0.0};
        double x = 0.20;
        while (patient.package().ct.nearestOr(referenceFromDeformed(package.motion, breath, {x, 0.0, 0.0}),
                                              -1000) < -300)
            x -= 0.0005;
        skin_m = {x, 0.0, 0.0};
        const ToolContact contact = test::contactAt(skin_m, {-moved_m, 0.0, 0.0}, 0.006);
        for (int i = 0; i < 6; ++i)
            tool.update({&contact, 1}, breath, 0.011);
        scene.breath = breath;
        scene.look = Look::closed;
        scene.table = false;
        scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
        scene.tool = &tool.table();
        eyes = test::stereo(test::lookAt(Vec3(0.34, 1.10, 0.10), skin_m + Vec3(0, 1, 0), 0.25f), 0.063);
    }

    patient::Package package = test::makeTrunk(0.003);
    patient::Patient patient{package};
    ToolDisplacement tool{patient};
    Vec3 skin_m;
    RenderScene scene;
    std::array<View, 2> eyes;
};

TEST(ToolPicture, GpuLookUpMatchesTheProcessor) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    const Pressed pressed(0.008, 0.8);
    Gpu gpu({.validation = true});
    DeformedPatient deformed(gpu, pressed.patient);
    deformed.breathe(pressed.scene.breath, false);
    deformed.press(pressed.scene.tool);
    EXPECT_EQ(deformed.imageRevision(), 1);
    const DeformTables tables = deformTables(pressed.package.motion, pressed.scene.breath);
    std::vector<Vec3> points_m;
    for (double x = -0.070; x <= 0.070; x += 0.0071)
        for (double y = -0.060; y <= 0.060; y += 0.0067)
            for (double z = -0.060; z <= 0.060; z += 0.0073) {
                const Vec3 p = pressed.skin_m + Vec3(x, y, z);
                if (test::inBody(pressed.package, pressed.scene.breath, p) &&
                    std::fabs(patient::cavityLevel_m(pressed.package.motion, pressed.scene.breath, p)) >
                        0.010)
                    points_m.push_back(p);
            }
    const std::vector<Vec3> found_m = test::referenceOnGpu(gpu, deformed, points_m);
    double worst_m = 0.0, max_m = 0.0;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
        const Vec3 twin = referenceFromTables(tables, pressed.tool.table(), points_m[i]);
        worst_m = std::max(worst_m, glm::length(found_m[i] - twin));
        max_m = std::max(max_m, glm::length(displacementAt(pressed.tool.table(), points_m[i])));
    }
    EXPECT_GT(max_m, 0.006);
    EXPECT_LT(worst_m, 5e-5);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

class ToolPictureTest
    : public test::GpuFixture<testing::TestWithParam<std::tuple<double, double, VolumePath>>> {};

TEST_P(ToolPictureTest, SkipsDoNotChangeThePicture) {
    const auto [moved_m, v, path] = GetParam();
    Pressed pressed(moved_m, v);
    Gpu gpu({.validation = true});
    Renderer renderer(gpu, {}, test::assetsFolder());
    renderer.setPatient(pressed.patient);
    const auto drawWith = [&](const Skips& skips, RenderStats* stats) {
        RenderSettings settings;
        settings.volume_path = path;
        settings.skips = skips;
        settings.count = true;
        renderer.setSettings(settings);
        return renderer.drawToImages(pressed.scene, pressed.eyes, kToolPictureSize, kToolPictureSize, stats);
    };
    RenderStats with, without;
    const patient::DisplacementTable* pressing = std::exchange(pressed.scene.tool, nullptr);
    const auto untouched = drawWith({}, &with);
    EXPECT_EQ(with.idle_tool_frames, 1u);
    pressed.scene.tool = pressing;
    const auto shown = drawWith({}, &with);
    EXPECT_EQ(with.idle_tool_frames, 0u);
    // Rays must not skip skin that was pulled out of its brick.
    const auto all = drawWith({.empty_space = false}, &without);
    EXPECT_GT(without.samples, with.samples);
    for (std::size_t eye = 0; eye < 2; ++eye)
        EXPECT_GE(test::psnr(shown[eye], all[eye]), 60.0);

    // After release the picture changes and equals that of an untouched patient, with and without the skip.
    pressed.scene.tool = nullptr;
    const auto still = drawWith({}, &with);
    EXPECT_EQ(with.idle_tool_frames, 1u);
    EXPECT_LT(test::psnr(shown[0], still[0]), 40.0);
    const auto asked = drawWith({.idle_tool = false}, &without);
    EXPECT_EQ(without.idle_tool_frames, 0u);
    for (std::size_t eye = 0; eye < 2; ++eye)
        for (const Image* of : {&untouched[eye], &asked[eye]})
            EXPECT_GE(test::psnr(still[eye], *of), 60.0);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}
INSTANTIATE_TEST_SUITE_P(PressedAndDrawn, ToolPictureTest,
                         testing::Combine(testing::Values(0.010, -0.010), testing::Values(0.0, 0.8),
                                          testing::Values(VolumePath::gpu, VolumePath::processor)));

// If one side of a ball is pulled out, the outline there moves by that distance.
TEST(ToolPicture, OutlineMovesByTheToolDisplacement) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.04, 0.03, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene;
    scene.look = Look::closed;
    scene.table = false;
    const std::uint32_t size = 256;
    const float half_angle = 0.2f;
    const double distance_m = 0.4, pixels_per_m = size / (2.0 * std::tan(double(half_angle)) * distance_m);
    const auto eyes = test::stereo(test::lookAt(Vec3(0, 0, distance_m), Vec3(0.0), half_angle), 0.0);
    // Columns of the middle row that show the ball.
    const auto right = [&] {
        const Image image = renderer.drawToImages(scene, eyes, size, size)[0];
        const auto at = [&](std::uint32_t x) {
            const std::uint8_t* p = &image.rgba[(std::size_t(size / 2) * size + x) * 4];
            return int(p[0]) - int(p[2]);  // skin and liver are red, the room is not
        };
        std::uint32_t x = size - 1;
        while (x > size / 2 && at(x) < 25)
            --x;
        return double(x);
    };
    const double still = right();
    for (const double moved_m : {0.006, -0.006}) {
        ToolDisplacement tool(shown.patient);
        const ToolContact contact = test::contactAt({0.04, 0.0, 0.0}, {moved_m, 0.0, 0.0}, 0.009);
        for (int i = 0; i < 8; ++i)
            tool.update({&contact, 1}, {}, 0.011);
        scene.tool = &tool.table();
        EXPECT_NEAR(right() - still, moved_m * pixels_per_m, 2.0) << moved_m;
        scene.tool = nullptr;
    }
}

}  // namespace
}  // namespace stylet::render
