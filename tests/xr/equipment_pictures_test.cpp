// The pictures on the equipment's screens. They are rendered only while visible, and no more often than the
// speed of sound and the X-ray pulses allow. Otherwise the last picture stays.
#include "app/trainer/view/equipment_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/support/phantom.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using patient::Tissue;

constexpr render::VisibleScreens kBoth{true, true, false};

class EquipmentPicturesTest : public testing::Test {
  protected:
    // The body begins at x = 0 and extends along +x. The probe's +z points into the body.
    EquipmentPicturesTest() {
        moment_.patient_from_probe =
            Pose{Quat{std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0}, Vec3(0.001, 0.0, 0.0)};
        moment_.patient_from_isocentre.position_m = {0.05, 0.0, 0.0};
    }
    void look(double time_s, const render::VisibleScreens& seen = kBoth) {
        moment_.time_s = time_s;
        pictures_.show(moment_, seen);
    }
    void pulse() { ++moment_.equipment.xray.pulses; }
    static double brightness(const render::ScreenPicture& screen) {
        double sum = 0.0;
        for (int i = 0; i < screen.width * screen.height; ++i)
            sum += screen.rgba[4 * i];
        return sum / (screen.width * screen.height);
    }

    const patient::Package package_ =
        test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::soft, 0.018}, {Tissue::liver, 0.080}}, 0.001);
    const patient::Patient patient_{package_};
    render::Gpu gpu_{{}};
    render::DeformedPatient deformed_{gpu_, patient_};
    EquipmentPictures pictures_{gpu_, deformed_, std::getenv("STYLET_ASSETS")};
    ImagingInput moment_;
};

TEST_F(EquipmentPicturesTest, InvisiblePicturesAreNotRendered) {
    moment_.equipment.xray.pedal = true;
    pulse();
    look(0.0, {});
    EXPECT_EQ(pictures_.totals().scans, 0u);
    EXPECT_EQ(pictures_.totals().xray_pictures, 0u);
    EXPECT_EQ(pictures_.totals().unseen, 2u);
    EXPECT_EQ(pictures_.ultrasoundScreen().width, 0);
    EXPECT_EQ(pictures_.xrayScreen().width, 0);
    look(0.01);
    EXPECT_EQ(pictures_.totals().scans, 1u);
    EXPECT_EQ(pictures_.totals().xray_pictures, 1u);
    EXPECT_GT(brightness(pictures_.ultrasoundScreen()), 3.0);
    EXPECT_GT(brightness(pictures_.xrayScreen()), 3.0);
}

TEST_F(EquipmentPicturesTest, UnusedEquipmentStaysDark) {
    moment_.patient_from_probe.reset();
    for (double t_s = 0.0; t_s < 1.0; t_s += 0.1)
        look(t_s);
    EXPECT_EQ(pictures_.ultrasoundScreen().width, 0);
    EXPECT_EQ(pictures_.xrayScreen().width, 0);
}

// Sound takes 53 ms to travel 256 lines of 16 cm and back.
TEST_F(EquipmentPicturesTest, TheScanRateIsLimitedByTheSpeedOfSound) {
    for (int i = 0; i < 100; ++i)
        look(0.010 * i);
    EXPECT_NEAR(double(pictures_.totals().scans), 1.0 / 0.060, 2.0);
    moment_.equipment.ultrasound.depth_m = 0.08;
    const std::uint64_t before = pictures_.totals().scans;
    for (int i = 100; i < 200; ++i)
        look(0.010 * i);
    EXPECT_NEAR(double(pictures_.totals().scans - before), 1.0 / 0.030, 2.0);
}

// The linear probe shows a strip as wide as its face. In the fan of the convex one the slab, which is not
// wider, fills less of a row. The machine's knob does not replace the probe that is felt.
TEST_F(EquipmentPicturesTest, ThePictureIsThatOfTheProbe) {
    const auto litPixels = [&](double share) {  // in the row at this share of the height
        const render::ScreenPicture screen = pictures_.ultrasoundScreen();
        const int row = int(share * screen.height);
        int count = 0;
        for (int x = 0; x < screen.width; ++x)
            count += screen.rgba[4 * (row * screen.width + x)] > 4 ? 1 : 0;
        return count;
    };
    moment_.equipment.ultrasound.depth_m = 0.06;
    look(0.0);
    EXPECT_LT(litPixels(0.4), 210);
    EXPECT_LT(litPixels(0.6), 210);
    moment_.probe = {.transducer = "linear", .length_m = 0.040, .curvature_m = 10.0};
    look(1.0);
    const double strip = UltrasoundScreen::kHeight * 0.040 / 0.060;
    EXPECT_NEAR(litPixels(0.4), strip, 15);
    EXPECT_NEAR(litPixels(0.6), strip, 15);
}

// The side of the probe with the needle guide is the picture's left, and marked.
TEST_F(EquipmentPicturesTest, ThePicturesLeftIsMarked) {
    look(0.0);
    const render::ScreenPicture screen = pictures_.ultrasoundScreen();
    int left = 0, right = 0;
    for (int y = 0; y < screen.height; ++y)
        for (int x = 0; x < screen.width; ++x) {
            const std::uint8_t* p = screen.rgba + 4 * (y * screen.width + x);
            if (int(p[2]) - int(p[0]) > 60) (2 * x < screen.width ? left : right) += 1;
        }
    EXPECT_GT(left, 80);
    EXPECT_EQ(right, 0);
}

TEST_F(EquipmentPicturesTest, AnUnknownTransducerLeavesTheScreenDark) {
    moment_.probe.transducer = "none";
    testing::internal::CaptureStderr();
    look(0.0);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("none.toml"), std::string::npos);
    EXPECT_EQ(pictures_.totals().scans, 0u);
}

TEST_F(EquipmentPicturesTest, AFrozenPictureStays) {
    look(0.0);
    moment_.equipment.ultrasound.freeze = true;
    moment_.patient_from_probe->position_m.y += 0.03;
    look(1.0);
    EXPECT_EQ(pictures_.totals().frozen, 1u);
    const std::uint64_t revision = pictures_.ultrasoundScreen().revision;
    look(2.0);
    EXPECT_EQ(pictures_.ultrasoundScreen().revision, revision) << "nothing is new";
    moment_.equipment.ultrasound.gain_db = 6.0;
    const double before = brightness(pictures_.ultrasoundScreen());
    look(3.0);
    EXPECT_GT(brightness(pictures_.ultrasoundScreen()), before + 1.0) << "but the gain";
    EXPECT_EQ(pictures_.totals().scans, 1u) << "nothing was scanned again";
}

TEST_F(EquipmentPicturesTest, AProbeInAirIsRenderedOnce) {
    look(0.0);
    moment_.patient_from_probe.reset();
    look(1.0);
    const std::uint64_t revision = pictures_.ultrasoundScreen().revision;
    for (int i = 2; i < 6; ++i)
        look(double(i));
    EXPECT_EQ(pictures_.ultrasoundScreen().revision, revision);
}

TEST_F(EquipmentPicturesTest, TheLastImageIsHeldAndAnUnseenPulseIsRenderedLater) {
    training::XrayState& xray = moment_.equipment.xray;
    xray.pedal = true;
    pulse();
    look(0.0);
    for (int i = 1; i < 10; ++i)
        look(0.01 * i);
    EXPECT_EQ(pictures_.totals().xray_pictures, 1u) << "one a pulse";
    xray.pedal = false;
    const std::uint64_t live = pictures_.xrayScreen().revision;
    look(0.2);
    EXPECT_EQ(pictures_.totals().xray_pictures, 1u);
    EXPECT_GT(pictures_.xrayScreen().revision, live) << "it says that it is held";
    const std::uint64_t held = pictures_.xrayScreen().revision;
    look(0.3);
    EXPECT_EQ(pictures_.xrayScreen().revision, held);
    // The pulse happens while the screen is not visible. The picture rendered later must show the needle and
    // the C-arm as they were at the pulse, although both have changed since.
    pulse();
    moment_.patient_from_needle = Pose{Quat{std::sqrt(0.5), 0.0, -std::sqrt(0.5), 0.0}, Vec3(0.05, 0.0, 0.0)};
    EquipmentPictures watched(gpu_, deformed_, std::getenv("STYLET_ASSETS"));
    watched.show(moment_, kBoth);
    look(0.4, {});
    moment_.patient_from_needle.reset();
    moment_.equipment.xray.rotation_rad = 0.5;
    look(0.5);
    EXPECT_EQ(pictures_.totals().xray_pictures, 2u);
    const render::ScreenPicture late = pictures_.xrayScreen(), then = watched.xrayScreen();
    EXPECT_TRUE(std::equal(late.rgba, late.rgba + 4 * late.width * late.height, then.rgba))
        << "as it was then";
    moment_.dose.contrast_m3 = 2e-6;
    const std::uint64_t written = pictures_.xrayScreen().revision;
    look(0.6);
    EXPECT_GT(pictures_.xrayScreen().revision, written) << "what the ledger says";
    EXPECT_EQ(pictures_.totals().xray_pictures, 2u);
}

TEST_F(EquipmentPicturesTest, OnlyExistingPicturesAreSaved) {
    const test::TempFolder folder;
    look(0.0);
    pictures_.save(folder.path(), "skin");
    EXPECT_TRUE(std::filesystem::exists(folder / "skin_ultrasound.png"));
    EXPECT_FALSE(std::filesystem::exists(folder / "skin_xray.png")) << "the pedal was never pressed";
}

// The patient has more voxels per edge than a GPU image can have. The screens stay dark and the attempt
// continues.
// HZ-TEACH-21
TEST(MachineLimits, APatientTooLargeForTheDeviceLeavesTheScreensDark) {
    patient::Package package = test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::liver, 0.098}}, 0.002);
    render::Gpu gpu({});
    const auto limit = int(gpu.physicalDevice().getProperties().limits.maxImageDimension3D);
    package.ct.grid.dims = package.labels.grid.dims = {limit + 8, 4, 4};
    package.ct.grid.spacing_m = package.labels.grid.spacing_m = Vec3(0.001);
    package.ct.voxels.assign(package.ct.grid.voxelCount(), std::int16_t(40));
    package.labels.voxels.assign(package.ct.grid.voxelCount(), std::uint8_t(0));
    const patient::Patient patient(package);
    render::DeformedPatient deformed(gpu, patient);
    EquipmentPictures pictures(gpu, deformed, std::getenv("STYLET_ASSETS"));
    ImagingInput moment;
    moment.patient_from_probe = Pose{};
    moment.equipment.xray.pedal = true;
    moment.equipment.xray.pulses = 1;
    testing::internal::CaptureStderr();
    pictures.show(moment, kBoth);
    moment.time_s = 1.0;
    pictures.show(moment, kBoth);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("no ultrasound pictures"), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 2) << "once each:\n" << said;
    EXPECT_EQ(pictures.totals().scans, 0u);
}

// The needle's tip is at the origin. The guide line lies in the image plane.
TEST(ImagingInput, IsConvertedFromATick) {
    haptics::TickOutput tick;
    tick.tick = 1500;
    tick.tool = haptics::Tool::probe;
    tick.patient_from_tool = Pose{{1.0, 0.0, 0.0, 0.0}, Vec3(0.1, 0.0, 0.0)};
    ImagingInput m = makeImagingInput(tick, {}, {}, 0.001);
    EXPECT_DOUBLE_EQ(m.time_s, 1.5);
    ASSERT_TRUE(m.patient_from_probe);
    EXPECT_NEAR(glm::length(m.patient_from_probe->direction({0, 0, 1}) - Vec3(0, 0, -1)), 0.0, 1e-12)
        << "a probe looks away from the hand";
    EXPECT_FALSE(m.guide_m || m.patient_from_needle);
    tick.tool = haptics::Tool::needle;
    tick.probe_parked = true;
    tick.patient_from_probe = *m.patient_from_probe;
    m = makeImagingInput(tick, {}, {}, 0.001);
    ASSERT_TRUE(m.patient_from_needle && m.guide_m);
    for (const Vec3& p : *m.guide_m)
        EXPECT_NEAR((m.patient_from_probe->inverse() * p).y, 0.0, 1e-12) << "in the plane of the picture";
    // The line is as long as the needle, so that it meets each duct that the needle can reach.
    NeedleShape longer;
    longer.length_m = 0.200;
    m = makeImagingInput(tick, longer, {}, 0.001);
    EXPECT_NEAR(glm::length((*m.guide_m)[1] - (*m.guide_m)[0]), 0.200, 1e-12);
    EXPECT_EQ(m.needle, longer);
}

}  // namespace
}  // namespace stylet::trainer
