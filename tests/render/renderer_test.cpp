// Compares pictures with closed forms: where a ball of known size appears, how much a slab absorbs, and
// which object hides which.
#include "render/frame/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string_view>

#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/support/temp_folder.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kRendererPictureSize = 256;

class RendererTest : public test::GpuFixture<> {};

RenderScene bareScene(Look look) {
    RenderScene scene;
    scene.look = look;
    scene.table = false;
    scene.stage_from_patient.position_m = {0.0, 1.2, 0.0};
    return scene;
}

struct Extent {
    int left = int(kRendererPictureSize), right = -1, top = int(kRendererPictureSize), bottom = -1;
};

// The pixels in which two pictures differ by more than the backdrop's grain.
Extent differing(const Image& a, const Image& b) {
    Extent e;
    for (int y = 0; y < int(a.height); ++y)
        for (int x = 0; x < int(a.width); ++x) {
            const std::size_t at = (std::size_t(y) * a.width + std::size_t(x)) * 4;
            int difference = 0;
            for (std::size_t c = 0; c < 3; ++c)
                difference += std::abs(int(a.rgba[at + c]) - int(b.rgba[at + c]));
            if (difference < 40) continue;
            e.left = std::min(e.left, x), e.right = std::max(e.right, x + 1);
            e.top = std::min(e.top, y), e.bottom = std::max(e.bottom, y + 1);
        }
    return e;
}

double pixelFromTangent(double tangent, float angle_low, float angle_high) {
    const double low = std::tan(double(angle_low)), high = std::tan(double(angle_high));
    return double(kRendererPictureSize) * (tangent - low) / (high - low);
}

// The silhouette of a ball of radius r, at distance z and x off the axis, reaches from tan(theta - alpha)
// to tan(theta + alpha), with theta = atan(x / z) and sin(alpha) = r / |(x, z)|.
void expectSilhouette(const Extent& seen, const View& view, const Vec3& centre_eye, double radius_m) {
    const auto range = [&](double across) {
        const double theta = std::atan2(across, -centre_eye.z);
        const double alpha = std::asin(radius_m / std::hypot(across, centre_eye.z));
        return std::pair(std::tan(theta - alpha), std::tan(theta + alpha));
    };
    const double tolerance_px = 2.5;  // about one and a half voxels
    const auto [left, right] = range(centre_eye.x);
    EXPECT_NEAR(seen.left, pixelFromTangent(left, view.angle_left, view.angle_right), tolerance_px);
    EXPECT_NEAR(seen.right, pixelFromTangent(right, view.angle_left, view.angle_right), tolerance_px);
    const auto [low, high] = range(centre_eye.y);
    EXPECT_NEAR(seen.top,
                double(kRendererPictureSize) - pixelFromTangent(high, view.angle_down, view.angle_up),
                tolerance_px);
    EXPECT_NEAR(seen.bottom,
                double(kRendererPictureSize) - pixelFromTangent(low, view.angle_down, view.angle_up),
                tolerance_px);
}

// HZ-TEACH-04
TEST_F(RendererTest, BallHasTheCorrectSilhouetteInBothEyes) {
    const double radius = 0.05;
    const patient::Package package = test::makeBall(patient::Tissue::bone, radius, 0.006, 0.001);
    const patient::Patient patient(package);
    Gpu gpu({.validation = true});
    Renderer renderer(gpu, {}, test::assetsFolder());
    for (const bool asymmetric : {false, true}) {
        RenderScene scene = bareScene(Look::closed);
        const Vec3 centre = scene.stage_from_patient.position_m;
        View middle = test::lookAt(centre + Vec3(0.0, 0.0, 0.5), centre, 0.22f);
        if (asymmetric) middle.angle_left = -0.3f, middle.angle_up = 0.35f, middle.angle_down = -0.2f;
        const auto eyes = test::stereo(middle, 0.064);
        Renderer empty(gpu, {}, test::assetsFolder());
        const auto without = empty.drawToImages(scene, eyes, kRendererPictureSize, kRendererPictureSize);
        renderer.setPatient(patient);
        const auto with = renderer.drawToImages(scene, eyes, kRendererPictureSize, kRendererPictureSize);
        for (std::size_t eye = 0; eye < 2; ++eye)
            expectSilhouette(differing(with[eye], without[eye]), eyes[eye],
                             eyes[eye].stage_from_eye.inverse() * centre, radius);
    }
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

// Writes an asset folder whose looks are black glass of the given extinction.
void writeBlackGlass(const test::TempFolder& folder, double extinction_per_mm) {
    for (const char* part : {"rooms", "instruments"})
        std::filesystem::copy(test::assetsFolder() / part, folder / part);
    std::filesystem::create_directory(folder / "looks");
    for (const char* name : {"closed.toml", "reveal.toml"})
        std::ofstream(folder / "looks" / name)
            << "[surface]\nwrap = 0\nspecular = 0\nspecular_power = 1\nrim = 0\ngradient_voxels = "
               "1\nsmoothing_voxels = 1\nedge_low = 0\nedge_high = 1\n"
               "grazing_tint = \"#ffffff\"\n[[hu]]\nhu = 0\ncolour = \"#000000\"\nextinction_per_mm = 0\n"
               "[[rule]]\ntissue = \"liver\"\ncolour = \"#000000\"\nextinction_per_mm = "
            << extinction_per_mm << "\n";
}

double meanLinear(const Image& image) {
    double sum = 0.0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) {
            const double v = image.rgba[i + c] / 255.0;
            sum += v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
        }
    return sum;
}

// Beer-Lambert law: the transmission through thickness L with extinction s is exp(-s L), for every step
// size.
TEST_F(RendererTest, SlabTransmissionFollowsBeerLambert) {
    const test::TempFolder folder;
    const double extinction_per_m = 15.0, thickness = 0.050, spacing = 0.002;
    writeBlackGlass(folder, extinction_per_m / 1000.0);
    const patient::Package package =
        test::makeBlock(patient::Tissue::liver, Vec3(0.15, 0.15, thickness), spacing);
    const patient::Patient patient(package);
    Gpu gpu({});
    RenderScene scene = bareScene(Look::reveal);
    // The distant eye makes the rays parallel. It looks down at the lit floor, where the backdrop is
    // brightest.
    scene.stage_from_patient.rotation = glm::angleAxis(-std::acos(0.0), Vec3(1, 0, 0));
    const Vec3 centre = scene.stage_from_patient.position_m;
    const auto eyes = test::stereo(test::lookAt(centre + Vec3(0, 1.5, 1e-4), centre, 0.03f), 0.02);
    Renderer empty(gpu, {}, folder.path());
    const auto without = empty.drawToImages(scene, eyes, 64, 64);
    // At each face, half a voxel fades into the air outside. The integral of a^2 for a from 1/2 to 1 is
    // 7/24 of a voxel instead of 1/2.
    const double effective = thickness - 2.0 * (0.5 - 7.0 / 24.0) * spacing;
    for (const float step : {0.25f, 1.0f, 2.0f}) {
        Renderer renderer(gpu, {.ray_step_voxels = step}, folder.path());
        renderer.setPatient(patient);
        const auto with = renderer.drawToImages(scene, eyes, 64, 64);
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_NEAR(meanLinear(with[eye]) / meanLinear(without[eye]),
                        std::exp(-extinction_per_m * effective), 0.012)
                << step;
    }
}

test::Blob redHub(const Image& image) {
    return test::findBlob(image, [](int r, int g, int b) { return r > 160 && g < 100 && b < 100; });
}

// HZ-TEACH-05
TEST_F(RendererTest, NeedleIsVisibleInFrontHiddenBehindAndDimInsideTissue) {
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.05, 0.006, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene = bareScene(Look::closed);
    const Vec3 centre = scene.stage_from_patient.position_m;
    const auto eyes = test::stereo(test::lookAt(centre + Vec3(0.0, 0.0, 0.5), centre, 0.25f), 0.0);
    // The shaft lies across the view. The hub, z = 0.150 to 0.180 in the needle's frame, is in the centre
    // of the picture.
    const Quat across = glm::angleAxis(std::acos(0.0), Vec3(0, 1, 0));
    const auto drawAt = [&](double depth_m) {
        scene.patient_from_needle = Pose{across, Vec3(-0.168, 0.0, depth_m)};
        return redHub(renderer.drawToImages(scene, eyes, kRendererPictureSize, kRendererPictureSize)[0]);
    };
    const test::Blob front = drawAt(0.10);
    EXPECT_GT(front.pixels, 100u);
    EXPECT_NEAR(front.x, kRendererPictureSize / 2.0, 12.0);
    EXPECT_LT(drawAt(-0.10).pixels, 10u);  // steel seen past the ball's soft rim may look red
    EXPECT_LT(drawAt(0.0).pixels, 10u);
    scene.look = Look::reveal;
    const Image inside = [&] {
        scene.patient_from_needle = Pose{across, Vec3(-0.168, 0.0, 0.0)};
        return renderer.drawToImages(scene, eyes, kRendererPictureSize, kRendererPictureSize)[0];
    }();
    scene.patient_from_needle.reset();
    const Image without = renderer.drawToImages(scene, eyes, kRendererPictureSize, kRendererPictureSize)[0];
    const Extent seen = differing(inside, without);
    EXPECT_LT(seen.left, int(kRendererPictureSize) / 2);
    EXPECT_GT(seen.right, int(kRendererPictureSize) / 2);
    EXPECT_GT(drawAt(0.10).pixels, 100u);
}

bool offersLayered(const Gpu& gpu) {
    const auto extensions = gpu.physicalDevice().enumerateDeviceExtensionProperties();
    return std::ranges::any_of(extensions, [](const vk::ExtensionProperties& e) {
        return std::string_view(e.extensionName) == VK_EXT_SHADER_VIEWPORT_INDEX_LAYER_EXTENSION_NAME;
    });
}

// Blood hides the skin under it everywhere, also where its first samples contribute little.
TEST_F(RendererTest, BloodCoversTheSkin) {
    for (const VolumePath path : {VolumePath::gpu, VolumePath::processor}) {
        test::PatientRenderer shown(test::makeTrunk(0.003), {.volume_path = path});
        RenderScene scene = bareScene(Look::closed);
        scene.marks = {{MarkKind::blood, Vec3(0.148, 0.015, 0.0), 0.03, Vec3(0.0, -1.0, 0.0)}};
        // Below the highlight of the wet surface.
        const Vec3 at = scene.stage_from_patient * (scene.marks[0].reference_m - Vec3(0.0, 0.015, 0.0));
        const View view = test::lookAt(at + Vec3(0.12, 0.03, 0.02), at, 0.04f);
        const Image picture = shown.renderer.drawToImages(scene, test::stereo(view, 0.0), 96, 96)[0];
        const test::Blob red = test::findBlob(picture, [](int r, int g, int) { return r > 50 && g < 20; });
        EXPECT_GT(red.pixels, 96u * 96u * 9u / 10u) << int(path);
    }
}

TEST_F(RendererTest, AllStereoPathsDrawTheSamePicture) {
    const patient::Package package = test::makeTrunk(0.004);
    const patient::Patient patient(package);
    RenderScene scene;
    scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    scene.patient_from_needle = Pose{{1, 0, 0, 0}, Vec3(0.05, 0.06, 0.0)};
    const auto eyes = test::stereo(test::lookAt(Vec3(0.2, 1.5, 0.5), Vec3(0, 1, 0), 0.4f), 0.063);
    std::vector<std::array<Image, 2>> pictures;
    bool layer_from_vertices = false;
    for (const StereoPath path : {StereoPath::single, StereoPath::layered, StereoPath::multiview}) {
        try {
            Gpu gpu({.validation = true, .stereo = path});
            layer_from_vertices = offersLayered(gpu);
            Renderer renderer(gpu, {}, test::assetsFolder());
            renderer.setPatient(patient);
            pictures.push_back(renderer.drawToImages(scene, eyes, 128, 96));
            EXPECT_EQ(gpu.validationMessages(), 0u) << int(path);
        } catch (const GpuError& e) {
            ASSERT_NE(path, StereoPath::single) << e.what();
            EXPECT_FALSE(path == StereoPath::layered && layer_from_vertices) << e.what();
        }
    }
    if (pictures.size() < 2) GTEST_SKIP() << "this device has no way to draw both eyes in one pass";
    for (std::size_t i = 1; i < pictures.size(); ++i)
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_GT(test::psnr(pictures[i][eye], pictures[0][eye]), 60.0);
    EXPECT_LT(test::psnr(pictures[0][0], pictures[0][1]), 40.0) << "both eyes show the same picture";
}

TEST_F(RendererTest, ManyFramesCauseNoValidationMessages) {
    const patient::Package trunk = test::makeTrunk(0.005);
    const patient::Package ball = test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002);
    const patient::Patient first(trunk), second(ball);
    Gpu gpu({.validation = true});
    RenderSettings settings;
    settings.count = true;
    Renderer renderer(gpu, settings, test::assetsFolder());
    RenderScene scene;
    scene.stage_from_patient.position_m = {0.0, 1.0, 0.0};
    scene.reference_path_m = std::array<Vec3, 2>{Vec3(0.15, 0.05, 0.0), Vec3(0.05, 0.0, 0.0)};
    const auto eyes = test::stereo(test::lookAt(Vec3(0.2, 1.4, 0.6), Vec3(0, 1, 0), 0.4f), 0.063);
    renderer.drawToImages(scene, eyes, 64, 64);  // no patient yet
    renderer.setPatient(first);
    for (const double v : {0.0, 0.2, 0.4, 0.4, 0.0}) {
        scene.breath.v = v;
        scene.look = v > 0.3 ? Look::closed : Look::reveal;
        RenderStats stats;
        renderer.drawToImages(scene, eyes, v > 0.0 ? 64 : 80, 64, &stats);
        EXPECT_GT(stats.samples, 0u);
        EXPECT_GT(stats.gpu_ms, 0.0);
        EXPECT_EQ(stats.still_frames, v == 0.0 ? 1u : 0u);
    }
    renderer.setPatient(second);
    renderer.drawToImages(scene, eyes, 64, 64);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

TEST_F(RendererTest, MissingAssetsAreNamed) {
    Gpu gpu({});
    try {
        const Renderer renderer(gpu, {}, "/nonexistent");
        FAIL() << "no exception";
    } catch (const DataError& e) {
        EXPECT_NE(std::string(e.what()).find("/nonexistent"), std::string::npos);
    }
}

}  // namespace
}  // namespace stylet::render
