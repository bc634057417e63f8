// Every skip can be switched off: the picture stays the same, its counter goes to zero and the work
// increases.
#include <gtest/gtest.h>

#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kSkipsPictureSize = 160;

class SkipsTest : public test::GpuFixture<testing::TestWithParam<std::tuple<Look, double, VolumePath>>> {};

struct SkipsPicture {
    std::array<Image, 2> eyes;
    RenderStats stats;
};

TEST_P(SkipsTest, ChangeTheWorkButNotThePicture) {
    const auto [look, v, path] = GetParam();
    test::PatientRenderer shown(test::makeTrunk(0.003), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene;
    scene.look = look;
    scene.breath.v = v;
    scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    scene.patient_from_needle = Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), Vec3(0.06, 0.0, 0.0)};
    const auto eyes = test::stereo(test::lookAt(Vec3(0.35, 1.35, 0.35), Vec3(0, 1, 0), 0.35f), 0.063);
    const auto drawWith = [&](const Skips& skips) {
        RenderSettings settings;
        settings.volume_path = path;
        settings.skips = skips;
        settings.count = true;
        renderer.setSettings(settings);
        SkipsPicture picture;
        picture.eyes =
            renderer.drawToImages(scene, eyes, kSkipsPictureSize, kSkipsPictureSize, &picture.stats);
        return picture;
    };
    const SkipsPicture all = drawWith({});
    EXPECT_GT(all.stats.skipped_bricks, 0u);
    EXPECT_GT(all.stats.terminated_rays, 0u);
    EXPECT_GT(all.stats.depth_bounded_rays, 0u);
    EXPECT_EQ(all.stats.still_frames, v == 0.0 ? 1u : 0u);
    const auto expectSame = [&](const SkipsPicture& other, const char* skip) {
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_GE(test::psnr(all.eyes[eye], other.eyes[eye]), 60.0) << skip;
        EXPECT_EQ(all.stats.rays, other.stats.rays) << skip;
    };
    const SkipsPicture no_bricks = drawWith({.empty_space = false});
    expectSame(no_bricks, "empty_space");
    EXPECT_EQ(no_bricks.stats.skipped_bricks, 0u);
    EXPECT_GT(no_bricks.stats.samples, all.stats.samples);
    const SkipsPicture no_end = drawWith({.early_termination = false});
    expectSame(no_end, "early_termination");
    EXPECT_EQ(no_end.stats.terminated_rays, 0u);
    EXPECT_GT(no_end.stats.samples, all.stats.samples);
    const SkipsPicture no_bounds = drawWith({.depth_bounds = false});
    expectSame(no_bounds, "depth_bounds");
    EXPECT_EQ(no_bounds.stats.depth_bounded_rays, 0u);
    EXPECT_GT(no_bounds.stats.samples, all.stats.samples);
    const SkipsPicture no_still = drawWith({.still_breath = false});
    expectSame(no_still, "still_breath");
    EXPECT_EQ(no_still.stats.still_frames, 0u);
}

INSTANTIATE_TEST_SUITE_P(BothLooksStillAndBreathingOnBothPaths, SkipsTest,
                         testing::Combine(testing::Values(Look::closed, Look::reveal),
                                          testing::Values(0.0, 0.8),
                                          testing::Values(VolumePath::gpu, VolumePath::processor)));

TEST(Counters, AreZeroUnlessRequested) {
    if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderStats stats;
    const auto eyes = test::stereo(test::lookAt(Vec3(0.0, 0.0, 0.5), Vec3(0.0), 0.3f), 0.06);
    renderer.drawToImages({}, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.samples, 0u);
    EXPECT_EQ(stats.rays, 0u);
}

}  // namespace
}  // namespace stylet::render
