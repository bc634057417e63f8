// volume.comp and the processor implement the same march. Their results must agree.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kMarchPathPictureSize = 160;

struct Case {
    const char* name;
    Look look;
    double v;
    RenderSettings settings;
    bool surgery;
    bool pressed = false;
};
void PrintTo(const Case& c, std::ostream* out) {
    *out << c.name;
}

class MarchPathTest : public test::GpuFixture<testing::TestWithParam<Case>> {};

struct MarchPathPicture {
    std::array<Image, 2> eyes;
    std::array<DepthImage, 2> depths;
    RenderStats stats;
};

RenderScene makeScene(const Case& c) {
    RenderScene scene;
    scene.look = c.look;
    scene.breath.v = c.v;
    scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    scene.patient_from_needle = Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), Vec3(0.06, 0.0, 0.0)};
    if (!c.surgery) return scene;
    scene.cuts = {{Vec3(0, 0, 1), 0.03}, {glm::normalize(Vec3(-1, 0.5, 0)), 0.09}};
    const Vec3 flank(0.125, 0.05, 0.0);
    scene.marks = {{MarkKind::iodine, flank, 0.06},
                   {MarkKind::incision, flank, 0.01},
                   {MarkKind::puncture, flank + Vec3(0, 0, -0.02), 0.002},
                   {MarkKind::blood, flank + Vec3(0, 0.01, 0.012), 0.015}};
    return scene;
}

TEST_P(MarchPathTest, GpuAndProcessorDrawTheSamePicture) {
    const Case& c = GetParam();
    test::PatientRenderer shown(test::makeTrunk(0.003));
    Renderer& renderer = shown.renderer;
    patient::ToolDisplacement tool(shown.patient);
    const patient::ToolContact contact = test::contactAt({0.125, 0.05, 0.0}, {-0.008, 0.0, 0.0}, 0.012);
    RenderScene scene = makeScene(c);
    if (c.pressed && tool.update({&contact, 1}, scene.breath, 0.011)) scene.tool = &tool.table();
    ASSERT_EQ(scene.tool != nullptr, c.pressed);
    const auto eyes = test::stereo(test::lookAt(Vec3(0.35, 1.35, 0.35), Vec3(0, 1, 0), 0.35f), 0.063);
    const auto drawBy = [&](VolumePath path) {
        RenderSettings settings = c.settings;
        settings.volume_path = path;
        settings.count = true;
        renderer.setSettings(settings);
        MarchPathPicture p;
        p.eyes = renderer.drawToImages(scene, eyes, kMarchPathPictureSize, kMarchPathPictureSize, &p.stats,
                                       &p.depths);
        return p;
    };
    const MarchPathPicture by_gpu = drawBy(VolumePath::gpu), by_processor = drawBy(VolumePath::processor);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        EXPECT_GE(test::psnr(by_gpu.eyes[eye], by_processor.eyes[eye]), 50.0);
        std::size_t apart = 0;
        for (std::size_t i = 0; i < by_gpu.depths[eye].reversed.size(); ++i) {
            const float a = by_gpu.depths[eye].reversed[i], b = by_processor.depths[eye].reversed[i];
            apart += std::fabs(a - b) > 1e-3f * std::max(a, b) ? 1u : 0u;
        }
        // The point of half absorption may fall on either side of a sample.
        EXPECT_LE(double(apart), 0.005 * double(by_gpu.depths[eye].reversed.size()));
    }
    const auto near = [](std::uint64_t a, std::uint64_t b, const char* what) {
        EXPECT_NEAR(double(a), double(b), 0.005 * double(a) + 2.0) << what;
    };
    near(by_gpu.stats.rays, by_processor.stats.rays, "rays");
    near(by_gpu.stats.samples, by_processor.stats.samples, "samples");
    near(by_gpu.stats.skipped_bricks, by_processor.stats.skipped_bricks, "leaps");
    near(by_gpu.stats.terminated_rays, by_processor.stats.terminated_rays, "terminated");
    near(by_gpu.stats.depth_bounded_rays, by_processor.stats.depth_bounded_rays, "bounded");
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, MarchPathTest,
    testing::Values(Case{"closed", Look::closed, 0.0, {}, false},
                    Case{"reveal", Look::reveal, 0.0, {}, false},
                    Case{"breathing", Look::reveal, 0.8, {}, false},
                    Case{"surgery", Look::closed, 0.8, {}, true},
                    Case{"pressed", Look::closed, 0.8, {}, true, true},
                    Case{"half the pixels", Look::closed, 0.0, {.layer_scale = 0.5f}, true},
                    Case{"foveated", Look::reveal, 0.0, {.foveation = Foveation{0.15f, 0.3f}}, false}),
    [](const auto& of) {
        std::string name = of.param.name;
        std::replace(name.begin(), name.end(), ' ', '_');
        return name;
    });

}  // namespace
}  // namespace stylet::render
