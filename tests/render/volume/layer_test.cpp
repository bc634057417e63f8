// Tests the volume layer: reduced resolution, skipped parts, cuts, marks, and the depth submitted to the
// runtime.
#include "render/volume/layer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kLayerPictureSize = 192, kMiddle = kLayerPictureSize / 2;
constexpr double kBallRadius_m = 0.05, kBallDistance_m = 0.4;

const Quat kAcross = glm::angleAxis(std::acos(0.0), Vec3(0, 1, 0));  // a needle along x

// A ball of tissue in the centre of both eyes' views.
class LayerTest : public testing::TestWithParam<VolumePath> {
  protected:
    void SetUp() override {
        if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
        gpu.emplace(GpuSettings{.validation = true});
        renderer.emplace(*gpu, RenderSettings{.volume_path = GetParam(), .count = true},
                         test::assetsFolder());
        renderer->setPatient(patient);
        scene.look = Look::closed;
        scene.table = false;
        scene.stage_from_patient.position_m = {0.0, 1.2, 0.0};
        const Vec3 centre = scene.stage_from_patient.position_m;
        eyes = test::stereo(test::lookAt(centre + Vec3(0.0, 0.0, kBallDistance_m), centre, 0.2f), 0.0);
    }
    void TearDown() override {
        if (gpu) {
            EXPECT_EQ(gpu->validationMessages(), 0u);
        }
    }

    std::array<Image, 2> draw() {
        return renderer->drawToImages(scene, eyes, kLayerPictureSize, kLayerPictureSize, &stats, &depths);
    }
    std::array<Image, 2> drawWith(RenderSettings settings) {
        settings.count = true;
        settings.volume_path = GetParam();
        renderer->setSettings(settings);
        return draw();
    }
    // Metres along the eye's axis. Infinity where nothing was drawn.
    double depthAt(std::uint32_t x, std::uint32_t y) const {
        const double d = depths[0].reversed[std::size_t(y) * kLayerPictureSize + x];
        const RenderSettings s;
        const double near = s.near_m, far = s.far_m;
        return d > 0.0 ? near * far / (near + d * (far - near)) : std::numeric_limits<double>::infinity();
    }
    double tangentAt(std::uint32_t pixel) const {
        return std::tan(0.2) * ((pixel + 0.5) / (0.5 * kLayerPictureSize) - 1.0);
    }

    const patient::Package package = test::makeBall(patient::Tissue::bone, kBallRadius_m, 0.012, 0.001);
    const patient::Patient patient{package};
    std::optional<Gpu> gpu;
    std::optional<Renderer> renderer;
    RenderScene scene;
    std::array<View, 2> eyes;
    RenderStats stats;
    std::array<DepthImage, 2> depths;
};

std::array<int, 3> rgbAt(const Image& image, std::uint32_t x, std::uint32_t y) {
    const std::size_t at = (std::size_t(y) * image.width + x) * 4;
    return {image.rgba[at], image.rgba[at + 1], image.rgba[at + 2]};
}

// A ray with tangents (x, y) meets the ball where t^2 (1 + x^2 + y^2) - 2 t D + D^2 = r^2.
TEST_P(LayerTest, SubmittedDepthMatchesTheVisibleSurface) {
    draw();
    int on_ball = 0;
    for (std::uint32_t y = 8; y < kLayerPictureSize; y += 16)
        for (std::uint32_t x = 8; x < kLayerPictureSize; x += 16) {
            const double a = 1.0 + std::pow(tangentAt(x), 2) + std::pow(tangentAt(y), 2);
            const double inside = kBallDistance_m * kBallDistance_m -
                                  a * (kBallDistance_m * kBallDistance_m - kBallRadius_m * kBallRadius_m);
            const double rim = std::sqrt(a - 1.0) * kBallDistance_m / kBallRadius_m;
            if (rim > 0.9 && rim < 1.2) continue;  // skip grazing rays: the smoothed ball has no sharp edge
            if (rim > 1.0) {
                EXPECT_GT(depthAt(x, y), 1.0);
                continue;
            }
            ++on_ball;
            EXPECT_NEAR(depthAt(x, y), (kBallDistance_m - std::sqrt(inside)) / a, 0.0025) << x << ' ' << y;
        }
    EXPECT_GT(on_ball, 20);
}

TEST_P(LayerTest, SubmittedDepthIsTheNeedleWhereItIsInFront) {
    scene.patient_from_needle = Pose{kAcross, Vec3(-0.09, 0.0, 0.1)};
    draw();
    EXPECT_NEAR(depthAt(kMiddle, kMiddle), kBallDistance_m - 0.1, 0.002);
    scene.patient_from_needle->position_m.z = -0.1;
    draw();
    EXPECT_NEAR(depthAt(kMiddle, kMiddle), kBallDistance_m - kBallRadius_m, 0.0025);
}

TEST_P(LayerTest, SubmittedDepthWithoutAPatientIsThatOfTheMeshes) {
    renderer.emplace(*gpu, RenderSettings{.volume_path = GetParam()}, test::assetsFolder());
    scene.patient_from_needle = Pose{kAcross, Vec3(-0.09, 0.0, 0.1)};
    draw();
    EXPECT_NEAR(depthAt(kMiddle, kMiddle), kBallDistance_m - 0.1, 0.002);
    EXPECT_GT(depthAt(8, 8), 1.0);
}

TEST_P(LayerTest, LowerResolutionSavesRaysAndKeepsMeshEdges) {
    scene.patient_from_needle = Pose{kAcross, Vec3(-0.168, 0.0, 0.1)};
    const auto full = drawWith({.close_up = false});
    const std::uint64_t rays = stats.rays;
    const auto half = drawWith({.layer_scale = 0.5f, .close_up = false});
    EXPECT_NEAR(stats.layer_scale, 0.5, 0.01);
    EXPECT_NEAR(double(stats.rays), 0.25 * double(rays), 0.02 * double(rays));
    EXPECT_GT(test::psnr(full[0], half[0]), 34.0);
    // The hub covers exactly its own pixels at half resolution too.
    const auto isHub = [](int r, int g, int b) { return r > 160 && g < 100 && b < 100; };
    const test::Blob a = test::findBlob(full[0], isHub), b = test::findBlob(half[0], isHub);
    EXPECT_GT(a.pixels, 200u);
    EXPECT_NEAR(double(b.pixels), double(a.pixels), 0.03 * double(a.pixels));
}

TEST_P(LayerTest, FoveationSharesRaysAwayFromTheAxis) {
    const auto full = drawWith({.close_up = false});
    const std::uint64_t rays = stats.rays;
    const auto foveated =
        drawWith({.foveation = Foveation{.quarter = 0.06f, .sixteenth = 0.14f}, .close_up = false});
    EXPECT_LT(stats.rays, rays / 2);
    EXPECT_EQ(rgbAt(full[0], kMiddle, kMiddle), rgbAt(foveated[0], kMiddle, kMiddle));
    EXPECT_GT(test::psnr(full[0], foveated[0]), 25.0);
    EXPECT_LT(test::psnr(full[0], foveated[0]), 60.0) << "nothing was shared";
}

TEST_P(LayerTest, CloseUpDrawsAtMostThreeRaysPerVoxel) {
    const Vec3 centre = scene.stage_from_patient.position_m;
    eyes = test::stereo(test::lookAt(centre + Vec3(0.0, 0.0, 0.12), centre, 0.2f), 0.0);
    const auto with = drawWith({});
    const std::uint64_t rays = stats.rays;
    EXPECT_LT(stats.layer_scale, 0.5);
    const auto without = drawWith({.close_up = false});
    EXPECT_EQ(stats.layer_scale, 1.0);
    EXPECT_GT(stats.rays, 3 * rays);
    EXPECT_GT(test::psnr(with[0], without[0]), 40.0);
}

TEST_P(LayerTest, HiddenAreaIsNotMarched) {
    const auto whole = draw();
    const std::uint64_t samples = stats.samples;
    const float edge = std::tan(0.2f) * 1.1f;
    const std::array<glm::vec2, 4> left{glm::vec2(-edge, -edge), {0.0f, -edge}, {0.0f, edge}, {-edge, edge}};
    const std::array<std::uint32_t, 6> two{0, 1, 2, 0, 2, 3};
    renderer->setHiddenArea(0, left, two);
    const auto hidden = draw();
    EXPECT_LT(stats.samples, samples * 4 / 5);
    for (std::uint32_t x = 0; x < kLayerPictureSize; x += 16) {
        const auto seen = rgbAt(hidden[0], x, kMiddle);
        EXPECT_EQ(seen, x < kMiddle ? (std::array<int, 3>{0, 0, 0}) : rgbAt(whole[0], x, kMiddle)) << x;
        EXPECT_EQ(rgbAt(hidden[1], x, kMiddle), rgbAt(whole[1], x, kMiddle)) << x;
    }
    renderer->setHiddenArea(0, {}, {});
    EXPECT_EQ(draw()[0].rgba, whole[0].rgba);
}

TEST_P(LayerTest, CutPlaneRemovesTissueAndLeavesAFlatFace) {
    scene.cuts = {{Vec3(0.0, 0.0, 1.0), 0.01}};
    draw();
    for (const std::uint32_t x : {kMiddle - 20, kMiddle, kMiddle + 20})
        EXPECT_NEAR(depthAt(x, kMiddle), kBallDistance_m - 0.01, 0.0015) << x;
    scene.cuts = {{Vec3(0.0, 0.0, -1.0), -0.01}};  // cuts away the part behind the plane
    draw();
    EXPECT_NEAR(depthAt(kMiddle, kMiddle), kBallDistance_m - kBallRadius_m, 0.0025);
    scene.cuts = {{Vec3(0.0, 0.0, 1.0), -0.2}};
    const auto nothing = draw();
    EXPECT_EQ(stats.samples, 0u);
    EXPECT_GT(depthAt(kMiddle, kMiddle), 1.0);
}

TEST_P(LayerTest, MarksColourOnlyTheirOwnSkin) {
    const auto clean = draw();
    const Vec3 front(0.0, 0.0, kBallRadius_m);
    scene.marks = {{MarkKind::blood, front, 0.006, Vec3(0, 0, 1)}};
    const auto bloody = draw();
    const auto [r, g, b] = rgbAt(bloody[0], kMiddle, kMiddle);
    EXPECT_GT(r, 2 * g);
    EXPECT_GT(r, 2 * b);
    EXPECT_EQ(rgbAt(bloody[0], kMiddle + 40, kMiddle), rgbAt(clean[0], kMiddle + 40, kMiddle));
    // An incision is long and thin.
    scene.marks = {{MarkKind::incision, front, 0.008, Vec3(1, 0, 0)}};
    const auto cut = draw();
    const auto changed = [&](int dx, int dy) {
        const std::uint32_t x = std::uint32_t(int(kMiddle) + dx), y = std::uint32_t(int(kMiddle) + dy);
        return rgbAt(cut[0], x, y) != rgbAt(clean[0], x, y);
    };
    const int pixel =
        int(kMiddle / std::tan(0.2) / (kBallDistance_m - kBallRadius_m) * 0.001);  // one millimetre
    EXPECT_TRUE(changed(0, 0));
    EXPECT_TRUE(changed(6 * pixel, 0));
    EXPECT_FALSE(changed(0, 6 * pixel));
}

// With the lamp on, a needle over the ball also darkens the part of the ball in its shadow.
TEST_P(LayerTest, ToolsCastTheLampsShadowOnTheSkin) {
    scene.field_m = Vec3(0.0, 0.035, 0.035);
    const auto changedBy = [&](bool lamp, std::size_t& darker) {
        scene.room.lamp = lamp;
        scene.patient_from_needle.reset();
        const Image without = draw()[0];
        scene.patient_from_needle = Pose{kAcross, Vec3(-0.05, 0.050, 0.042)};
        const Image with = draw()[0];
        std::size_t changed = 0;
        darker = 0;
        for (std::size_t i = 0; i < with.rgba.size(); i += 4) {
            const int difference = int(with.rgba[i + 1]) - int(without.rgba[i + 1]);
            changed += std::abs(difference) > 6 ? 1u : 0u;
            darker += difference < -6 && with.rgba[i + 1] > 20 ? 1u : 0u;
        }
        return changed;
    };
    std::size_t darker_by_lamp = 0, darker_without = 0;
    const std::size_t by_lamp = changedBy(true, darker_by_lamp),
                      without_lamp = changedBy(false, darker_without);
    EXPECT_GT(without_lamp, 100u) << "the needle itself";
    EXPECT_GT(by_lamp, without_lamp + without_lamp / 4);
    EXPECT_GT(darker_by_lamp, darker_without + without_lamp / 4);
}

TEST_P(LayerTest, OnlyTheNewestMarksAreShown) {
    const Vec3 front(0.0, 0.0, kBallRadius_m);
    for (int i = 0; i < kMaxMarksShown + 4; ++i)
        scene.marks.push_back({MarkKind::puncture, Vec3(0.0, 0.0, -kBallRadius_m), 0.001, Vec3(0, 0, 1)});
    scene.marks.push_back({MarkKind::blood, front, 0.006, Vec3(0, 0, 1)});
    const auto [r, g, b] = rgbAt(draw()[0], kMiddle, kMiddle);
    EXPECT_GT(r, 2 * std::max(g, b));
}

INSTANTIATE_TEST_SUITE_P(GpuAndProcessor, LayerTest, testing::Values(VolumePath::gpu, VolumePath::processor));

}  // namespace
}  // namespace stylet::render
