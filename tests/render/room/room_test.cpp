// Tests the room in pictures: skips do not change the picture, objects in the lamp's light cast shadows,
// and screens show their pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "render/room/placement.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kRoomPictureSize = 192;

class RoomTest : public test::GpuFixture<> {
  protected:
    static RenderScene wholeRoom() {
        RenderScene scene;
        scene.look = Look::closed;
        const double half = std::sqrt(0.5);
        scene.stage_from_patient = {{half, 0.0, -half, 0.0}, {0.0, 1.06, -0.6}};
        scene.room = {true, true, true, true, true, true, CArm{0.2, -0.1}};
        scene.field_m = Vec3(0.14, 0.02, 0.0);
        scene.drape = true;
        scene.patient_from_needle = Pose{glm::angleAxis(1.2, Vec3(0, 1, 0)), Vec3(0.13, 0.02, 0.0)};
        scene.patient_from_probe = Pose{glm::angleAxis(1.4, Vec3(0, 1, 0)), Vec3(0.14, 0.05, 0.06)};
        scene.paths = {{Vec3(0.14, 0.02, 0.0), Vec3(0.04, 0.0, 0.0), 0.3}};
        return scene;
    }
    const std::array<View, 2> eyes =
        test::stereo(test::lookAt(Vec3(0.0, 1.62, 0.1), Vec3(-0.2, 1.05, -0.7), 0.6f), 0.063);
};

TEST_F(RoomTest, CullingUnseenPartsDoesNotChangeThePicture) {
    test::PatientRenderer shown(test::makeTrunk(0.004));
    Renderer& renderer = shown.renderer;
    const RenderScene scene = wholeRoom();
    RenderStats with, without;
    const auto culled = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize, &with);
    RenderSettings settings;
    settings.skips.unseen_parts = false;
    renderer.setSettings(settings);
    const auto all = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize, &without);
    EXPECT_GT(with.culled_parts, 3u);
    EXPECT_EQ(without.culled_parts, 0u);
    for (std::size_t eye = 0; eye < 2; ++eye)
        EXPECT_GE(test::psnr(culled[eye], all[eye]), 60.0);
}

// The shell light affects only walls and floor: no pixel of the patient, the table or the held tool. With
// the default shell light the picture is bit-identical.
TEST_F(RoomTest, ShellLightDoesNotAffectPatientAndTools) {
    test::PatientRenderer shown(test::makeTrunk(0.004));
    Renderer& renderer = shown.renderer;
    RenderScene scene = wholeRoom();
    const auto plain = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize);
    scene.room.shell_light = {1.5, 0.36, 0.32};
    const auto red = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize);
    scene.room.shell_light = Vec3(1.0);
    const auto again = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize);
    // Without the shell, only the objects in the room remain, in front of an empty backdrop.
    scene.room.shell = false, scene.room.real = true;
    const auto things = renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        EXPECT_EQ(plain[eye].rgba, again[eye].rgba);
        int same = 0, redder = 0;
        for (std::size_t i = 0; i < plain[eye].rgba.size(); i += 4) {
            const auto at = [&](const Image& image, std::size_t c) { return int(image.rgba[i + c]); };
            const bool thing = at(things[eye], 3) == 255;
            const bool equal = at(plain[eye], 0) == at(red[eye], 0) && at(plain[eye], 1) == at(red[eye], 1) &&
                               at(plain[eye], 2) == at(red[eye], 2);
            EXPECT_TRUE(!thing || equal) << "pixel " << i / 4;
            same += equal;
            redder += at(red[eye], 0) > at(plain[eye], 0) && at(red[eye], 1) < at(plain[eye], 1);
        }
        EXPECT_GT(redder, int(kRoomPictureSize * kRoomPictureSize / 5));
        EXPECT_GT(same, int(kRoomPictureSize * kRoomPictureSize / 5));
    }
}

TEST_F(RoomTest, ShadowMapIsReusedUntilACasterMoves) {
    test::PatientRenderer shown(test::makeTrunk(0.004));
    Renderer& renderer = shown.renderer;
    RenderScene scene = wholeRoom();
    RenderStats stats;
    renderer.drawToImages(scene, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.reused_shadows, 0u);
    const auto kept = renderer.drawToImages(scene, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.reused_shadows, 1u);
    RenderSettings settings;
    settings.skips.still_shadows = false;
    renderer.setSettings(settings);
    const auto anew = renderer.drawToImages(scene, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.reused_shadows, 0u);
    EXPECT_GE(test::psnr(kept[0], anew[0]), 60.0);
    renderer.setSettings({});
    // The head moves and a path is removed. Neither casts a shadow. The parts of the wire come in another
    // order, because others are now the nearest.
    scene.tubes.resize(1);
    scene.tubes[0].points_m = {Vec3(0.30, 0.0, -0.3), Vec3(0.30, 0.0, -0.1), Vec3(0.30, 0.0, 0.1),
                               Vec3(0.30, 0.0, 0.3)};
    renderer.drawToImages(scene, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.reused_shadows, 0u);
    scene.paths.clear();
    for (const double x : {-1.5, 1.5}) {
        const View moved = test::lookAt(Vec3(x, 1.6, 0.4), Vec3(0, 1, -0.6), 0.5f);
        renderer.drawToImages(scene, test::stereo(moved, 0.063), 64, 64, &stats);
        EXPECT_EQ(stats.reused_shadows, 1u) << x;
    }
    scene.patient_from_needle->position_m.y += 0.001;
    renderer.drawToImages(scene, eyes, 64, 64, &stats);
    EXPECT_EQ(stats.reused_shadows, 0u);
}

// Lamps that are switched off stay where they are. Nothing in the room becomes brighter.
TEST_F(RoomTest, LampsOffDarkenTheRoom) {
    test::PatientRenderer shown(test::makeTrunk(0.004));
    RenderScene scene = wholeRoom();
    RenderStats on, off;
    const auto draw = [&](RenderStats& stats) {
        return shown.renderer.drawToImages(scene, eyes, kRoomPictureSize, kRoomPictureSize, &stats)[0];
    };
    const Image lit = draw(on);
    scene.room.lamp_lit = false;
    const Image dark = draw(off);
    EXPECT_EQ(on.culled_parts, off.culled_parts);
    std::size_t brighter = 0;
    double sum_lit = 0.0, sum_dark = 0.0;
    for (std::size_t i = 0; i < lit.rgba.size(); i += 4) {
        brighter += dark.rgba[i + 1] > lit.rgba[i + 1] + 2;
        sum_lit += lit.rgba[i + 1], sum_dark += dark.rgba[i + 1];
    }
    EXPECT_LT(brighter, lit.rgba.size() / 4 / 200);
    EXPECT_LT(sum_dark, 0.9 * sum_lit);
}

// A path is thinner than a pixel here, and does not break into dashes.
TEST_F(RoomTest, APathIsAWholeLineFromFarAway) {
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002), {}, false);
    RenderScene scene;
    scene.look = Look::closed;
    scene.stage_from_patient.position_m = {0.0, 1.06, 0.0};
    scene.table = false;
    scene.reference_path_m = std::array{Vec3(0.30, 0.03, 0.2), Vec3(0.05, 0.0, 0.2)};
    const View view = test::lookAt(Vec3(0.1, 1.3, 1.8), Vec3(0.15, 1.06, 0.0), 0.3f);
    const Image picture =
        shown.renderer.drawToImages(scene, test::stereo(view, 0.0), kRoomPictureSize, kRoomPictureSize)[0];
    const double pixel_m = 2.0 * 1.8 * std::tan(0.3) / kRoomPictureSize;
    EXPECT_GT(pixel_m, 0.0055) << "five times the path's width";
    const auto cyan =
        test::findBlob(picture, [](int r, int g, int b) { return b > 150 && r < 120 && g > 120; });
    EXPECT_GT(double(cyan.pixels), 0.25 / pixel_m);
}

// A highlight glows where it is placed, in either frame, and casts no shadow. Without one nothing is drawn.
TEST_F(RoomTest, HighlightsGlowWhereTheyAre) {
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene;
    scene.look = Look::closed;
    scene.stage_from_patient.position_m = {0.0, 1.06, 0.0};
    scene.room.lamp = true;
    const Vec3 beside(0.15, 0.0, 0.0);  // patient frame
    const View view = test::lookAt(Vec3(0.5, 1.5, 0.3), scene.stage_from_patient * beside, 0.25f);
    const auto both = test::stereo(view, 0.0);
    RenderStats stats;
    const auto magenta = [&] {
        const Image picture =
            renderer.drawToImages(scene, both, kRoomPictureSize, kRoomPictureSize, &stats)[0];
        return test::findBlob(picture, [](int r, int g, int b) { return r > 150 && g < 110 && b > 120; });
    };
    EXPECT_EQ(magenta().pixels, 0u);
    scene.highlights = {{.at_m = beside, .along = Vec3(0.0, -1.0, 0.0), .ring_m = 0.02, .arrow_m = 0.05}};
    const auto in_patient = magenta();
    EXPECT_GT(in_patient.pixels, 60u);
    EXPECT_NEAR(in_patient.x, 0.5 * kRoomPictureSize, 0.08 * kRoomPictureSize);
    EXPECT_EQ(stats.reused_shadows, 1u) << "the shadow map is that of the picture before";
    scene.highlights[0].ring_m = 0.0;
    const std::size_t arrow = magenta().pixels;
    EXPECT_GT(arrow, 10u);
    EXPECT_LT(arrow, in_patient.pixels);
    // The same place in the room's frame.
    scene.highlights[0].in_room = true;
    EXPECT_EQ(magenta().pixels, 0u);
    const Placement placed = computePlacement(scene, nullptr);
    scene.highlights[0].at_m = placed.stage_from_room.inverse() * (scene.stage_from_patient * beside);
    scene.highlights[0].along = placed.stage_from_room.inverse().direction(Vec3(0.0, -1.0, 0.0));
    EXPECT_NEAR(double(magenta().pixels), double(arrow), 0.2 * double(arrow));
}

// Every other pixel of a ghost shows what is behind it.
TEST_F(RoomTest, GhostIsTranslucentAndCastsNoShadow) {
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene;
    scene.look = Look::closed;
    scene.stage_from_patient.position_m = {0.0, 1.06, 0.0};
    scene.room.lamp = true;
    const Pose beside{{1.0, 0.0, 0.0, 0.0}, {0.15, 0.0, 0.0}};
    const View view =
        test::lookAt(Vec3(0.5, 1.5, 0.3), scene.stage_from_patient * Vec3(0.15, 0.0, 0.05), 0.25f);
    const auto both = test::stereo(view, 0.0);
    RenderStats stats;
    const auto draw = [&] {
        return renderer.drawToImages(scene, both, kRoomPictureSize, kRoomPictureSize, &stats)[0];
    };
    const auto changed = [](const Image& a, const Image& b, int parity) {
        std::size_t count = 0;
        for (std::uint32_t y = 0; y < kRoomPictureSize; ++y)
            for (std::uint32_t x = 0; x < kRoomPictureSize; ++x) {
                const std::size_t at = 4 * (std::size_t(y) * kRoomPictureSize + x);
                count +=
                    parity == int((x + y) & 1u) && !std::equal(&a.rgba[at], &a.rgba[at] + 3, &b.rgba[at]);
            }
        return count;
    };
    const Image without = draw();
    for (const GhostKind kind :
         {GhostKind::needle, GhostKind::probe, GhostKind::scalpel, GhostKind::finger}) {
        scene.ghost = {kind, beside};
        const Image with = draw();
        const std::size_t even = changed(with, without, 0), odd = changed(with, without, 1);
        EXPECT_GT(std::max(even, odd), 15u) << int(kind);
        EXPECT_EQ(std::min(even, odd), 0u) << int(kind);
        EXPECT_EQ(stats.reused_shadows, 1u) << int(kind);
    }
}

double luminanceAt(const Image& image, const View& view, const Vec3& stage) {
    const Vec3 p = view.stage_from_eye.inverse() * stage;
    const auto pixel = [&](double tangent, float low, float high) {
        const double a = std::tan(double(low)), b = std::tan(double(high));
        return int((tangent - a) / (b - a) * kRoomPictureSize);
    };
    const int x = pixel(p.x / -p.z, view.angle_left, view.angle_right);
    const int y = int(kRoomPictureSize) - 1 - pixel(p.y / -p.z, view.angle_down, view.angle_up);
    double sum = 0.0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            for (std::size_t c = 0; c < 3; ++c)
                sum += std::pow(
                    image.rgba[(std::size_t(y + dy) * kRoomPictureSize + std::size_t(x + dx)) * 4 + c] /
                        255.0,
                    2.2);
    return sum;
}

// The finger is above the table. Its shadow lies where the line from the lamp through it meets the pad.
TEST_F(RoomTest, ShadowFallsOnlyOppositeTheLamp) {
    test::PatientRenderer shown(test::makeBall(patient::Tissue::liver, 0.03, 0.01, 0.002), {}, false);
    Renderer& renderer = shown.renderer;
    RenderScene scene;
    scene.look = Look::closed;
    scene.stage_from_patient.position_m = {0.0, 1.06, 0.0};
    scene.room.lamp = true;
    scene.field_m = Vec3(0.0, 0.0, 0.20);
    const Vec3 lamp = computePlacement(scene, nullptr).lamp.stage_m;
    const double pad = 1.06 - 0.03;
    // The centre of the hand's wrist, 0.17 m behind the fingertip.
    const Vec3 wrist = Vec3(0.02, 1.06 + 0.15, 0.20);
    const Vec3 shadow = lamp + (wrist - lamp) * ((lamp.y - pad) / (lamp.y - wrist.y));
    const View view = test::lookAt(Vec3(0.5, 1.45, 0.25), shadow, 0.35f);
    const auto both = test::stereo(view, 0.0);
    const auto without = renderer.drawToImages(scene, both, kRoomPictureSize, kRoomPictureSize);
    scene.patient_from_finger = Pose{{1, 0, 0, 0}, Vec3(0.02 + 0.026, 0.15, 0.20 - 0.17)};
    const auto with = renderer.drawToImages(scene, both, kRoomPictureSize, kRoomPictureSize);
    const auto share = [&](const Vec3& p) {
        return luminanceAt(with[0], view, p) / luminanceAt(without[0], view, p);
    };
    EXPECT_LT(share(shadow), 0.7);
    EXPECT_NEAR(share(shadow + Vec3(0.17, 0.0, 0.0)), 1.0, 0.05);
}

TEST_F(RoomTest, ScreenShowsItsPictureUntilTheRevisionChanges) {
    Gpu gpu({.validation = true});
    Renderer renderer(gpu, {}, test::assetsFolder());
    RenderScene scene;
    scene.room.xray_monitor = true;
    const Placement placed = computePlacement(scene, nullptr);
    const Vec3 screen = placed.stage_from_room * Vec3(-0.92, 1.58, 0.62);
    const auto near = test::stereo(test::lookAt(screen + Vec3(0.9, 0.0, -0.3), screen, 0.25f), 0.0);
    const auto green = [&] {
        const Image picture = renderer.drawToImages(scene, near, kRoomPictureSize, kRoomPictureSize)[0];
        return test::findBlob(picture, [](int r, int g, int b) { return g > 150 && r < 100 && b < 100; })
            .pixels;
    };
    EXPECT_EQ(green(), 0u);
    std::vector<std::uint8_t> rgba(300 * 200 * 4, 0);
    for (std::size_t i = 1; i < rgba.size(); i += 4)
        rgba[i] = 230;
    scene.xray_screen = {300, 200, rgba.data(), 1};
    const std::size_t green_pixels = green();
    EXPECT_GT(green_pixels, kRoomPictureSize * kRoomPictureSize / 8u);
    std::fill(rgba.begin(), rgba.end(), std::uint8_t(0));
    EXPECT_EQ(green(), green_pixels) << "uploaded again without a new revision";
    scene.xray_screen.revision = 2;
    EXPECT_EQ(green(), 0u);
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

// The renderer decides which screens are visible before their pictures are drawn. A screen reported as not
// visible must not appear in any picture.
TEST_F(RoomTest, VisibleScreensMatchTheRenderedPicture) {
    Gpu gpu({});
    Renderer renderer(gpu, {}, test::assetsFolder());
    RenderScene scene;
    scene.room.xray_monitor = true;
    const Vec3 screen = computePlacement(scene, nullptr).stage_from_room * Vec3(-0.92, 1.58, 0.62);
    const std::vector<std::uint8_t> white(64 * 48 * 4, 255);
    int seen_by = 0, hidden_from = 0;
    for (int i = 0; i < 16; ++i) {
        const Vec3 eye = screen + Vec3(1.1 * std::cos(0.4 * i), 0.2, 1.1 * std::sin(0.4 * i));
        const Vec3 aim = i % 2 ? screen + Vec3(0.1 * (i - 8), 0.0, 0.06 * i) : screen;
        const auto views = test::stereo(test::lookAt(eye, aim, 0.3f), 0.063);
        scene.xray_screen = {};
        const auto dark = renderer.drawToImages(scene, views, 96, 96);
        scene.xray_screen = {64, 48, white.data(), 1};
        const auto bright = renderer.drawToImages(scene, views, 96, 96);
        const VisibleScreens seen = renderer.visibleScreens(scene, views);
        EXPECT_FALSE(seen.ultrasound || seen.monitor) << "they are not in the room";
        const bool shows = dark[0].rgba != bright[0].rgba || dark[1].rgba != bright[1].rgba;
        EXPECT_TRUE(seen.xray || !shows) << i;
        ++(seen.xray ? seen_by : hidden_from);
    }
    EXPECT_GT(seen_by, 3);
    EXPECT_GT(hidden_from, 3);
    scene.room.xray_monitor = false;
    EXPECT_FALSE(renderer
                     .visibleScreens(
                         scene, test::stereo(test::lookAt(screen + Vec3(0.9, 0.0, -0.3), screen, 0.25f), 0.0))
                     .xray);
}

}  // namespace
}  // namespace stylet::render
