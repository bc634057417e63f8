// One needle in all pictures: the eye's view, the ultrasound picture, the X-ray picture and the wound. Each
// must show the diameter and the tip of the instrument's file, to a pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "app/trainer/view/scene.h"
#include "haptics/tools/instrument.h"
#include "tests/render/fluoroscopy/ray_reference.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/ultrasound/sound_phantoms.h"

namespace stylet::trainer {
namespace {

constexpr std::uint32_t kPixels = 512;

class NeedlePictures : public test::GpuFixture<testing::TestWithParam<const char*>> {
  protected:
    const NeedleShape needle_ =
        haptics::loadInstrument(test::assetsFolder() / "instruments" / (std::string(GetParam()) + ".toml"))
            .shape;
};
INSTANTIATE_TEST_SUITE_P(Of, NeedlePictures, testing::Values("needle-17g", "trocar-18g", "chiba-22g"),
                         [](const auto& of) {
                             std::string name = of.param;
                             std::erase(name, '-');
                             return name;
                         });

int difference(const render::Image& a, const render::Image& b, std::size_t pixel) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
        most = std::max(most, std::abs(int(a.rgba[4 * pixel + c]) - int(b.rgba[4 * pixel + c])));
    return most;
}

// The needle lies across the view, with its tip at the origin and its hub toward +x.
TEST_P(NeedlePictures, EyeView) {
    constexpr double kAway_m = 0.30, kAside_m = 0.010;
    constexpr float kHalf = 0.05f;
    const double pixel_m = 2.0 * kAway_m * std::tan(kHalf) / kPixels;
    test::PatientRenderer shown(test::emptyPackage(Vec3(0.05), 0.01));
    render::RenderScene scene;
    scene.table = false;
    scene.needle = needle_;
    const render::View view = test::lookAt({kAside_m, 0.0, kAway_m}, {kAside_m, 0.0, 0.0}, kHalf);
    const render::Image without = shown.renderer.drawToImages(scene, {view, view}, kPixels, kPixels)[0];
    scene.patient_from_needle = Pose{glm::angleAxis(M_PI / 2, Vec3(0, 1, 0)), Vec3(0.0)};
    const render::Image with = shown.renderer.drawToImages(scene, {view, view}, kPixels, kPixels)[0];
    int first = kPixels;
    std::vector<int> heights(kPixels, 0);
    for (std::uint32_t y = 0; y < kPixels; ++y)
        for (std::uint32_t x = 0; x < kPixels; ++x)
            if (difference(with, without, std::size_t(y) * kPixels + x) > 8)
                ++heights[x], first = std::min(first, int(x));
    const double tip_m = kAside_m + (first + 0.5 - 0.5 * kPixels) * pixel_m;
    // A ground tip becomes visible where it is a pixel wide.
    EXPECT_GT(tip_m, -pixel_m);
    EXPECT_LT(tip_m, (1.0 + 0.5 / std::tan(needle_.bevel_rad)) * pixel_m);
    // Between the ground tip and the first mark.
    const auto column = std::size_t((0.020 - kAside_m) / pixel_m + 0.5 * kPixels);
    EXPECT_NEAR(heights[column] * pixel_m, needle_.outer_m, 2.0 * pixel_m);
    EXPECT_LT(pixel_m, 0.00007);
}

// Rays at many distances from a slanted axis give the profile of the attenuation across the shaft. A pixel
// blurs the profile, but the area under it is that of a disc of steel.
TEST_P(NeedlePictures, Xray) {
    const patient::Package package =
        test::makeXrayPhantom(Vec3(0.05), 0.005, [](const Vec3&) { return -1000.0; });
    const patient::Patient patient(package);
    render::Gpu gpu({.validation = true});
    render::DeformedPatient deformed(gpu, patient);
    deformed.breathe(package.motion.reference, true);
    render::Fluoroscopy fluoroscopy(gpu, deformed);
    const Pose pose{glm::angleAxis(1.1, glm::normalize(Vec3(0.1, 1.0, 0.07))), {-0.05, 0.01, -0.01}};
    std::vector<render::XrayShape> shapes;
    render::addNeedle(pose, needle_, true, shapes);
    render::FluoroscopyInput input;
    input.pedal = true;
    input.shapes = shapes;
    render::FluoroscopySettings settings;
    settings.pixels = int(kPixels);
    settings.beyond_ends_m = 0.0;
    ASSERT_EQ(fluoroscopy.image(input, settings).reason, "");
    const Vec3 tip = pose.position_m, axis = pose.direction({0, 0, 1});
    constexpr double kBin_m = 0.00002;
    std::vector<double> sums(100), counts(100);  // by distance from the axis
    double first_hit_m = 1.0;
    for (std::size_t i = 0; i < std::size_t(kPixels) * kPixels; ++i) {
        const test::XrayLine line =
            test::xrayLine(input, int(i % kPixels), int(i / kPixels), settings.pixels, settings.detector_m);
        const Vec3 ray = glm::normalize(line.pixel_m - line.source_m), across = glm::cross(ray, axis);
        const Vec3 from = tip - line.source_m;
        const double away_m = std::fabs(glm::dot(from, across)) / glm::length(across);
        // Where on the axis the ray is nearest, from the tip.
        const double along_m = glm::dot(glm::cross(from, ray), across) / glm::dot(across, across);
        const bool hit = fluoroscopy.paths()[i] > 1e-3;
        if (along_m > -0.005 && along_m < 0.02 && hit) first_hit_m = std::min(first_hit_m, along_m);
        if (along_m < needle_.tipLength_m() || along_m > needle_.length_m - 0.01) continue;
        const auto bin = std::size_t(away_m / kBin_m);
        if (bin >= sums.size()) continue;
        sums[bin] += fluoroscopy.paths()[i] * glm::length(across);
        counts[bin] += 1.0;
    }
    double area = 0.0;  // attenuation times cross-section
    for (std::size_t bin = 0; bin < sums.size(); ++bin) {
        ASSERT_GT(counts[bin], 10.0);
        area += 2.0 * kBin_m * sums[bin] / counts[bin];
    }
    EXPECT_NEAR(2.0 * std::sqrt(area / (needle_.attenuation_per_m * std::numbers::pi)), needle_.outer_m,
                1e-5);
    EXPECT_GT(first_hit_m, -1e-5);
    EXPECT_LT(first_hit_m, 0.0006);  // a pixel
    EXPECT_EQ(gpu.validationMessages(), 0u);
}

// The needle lies across the middle of the picture, at a right angle to the beam. Sound that runs to and fro
// in the shaft makes echoes behind it at distances of the diameter.
TEST_P(NeedlePictures, Ultrasound) {
    const patient::Package package =
        test::soundBlock(Vec3(0.030, 0.012, 0.0), 0.070, 0.002, [](const Vec3&) { return "liver"; });
    render::UltrasoundSettings settings;
    settings.lines = 96;
    settings.samples = 2048;
    settings.planes = 1;
    settings.compensation_db_per_cm_mhz = 0.0;
    settings.noise_db = -400.0;
    const render::Transducer probe = test::flatProbe();
    render::UltrasoundInput input = test::probeAt(0.002);
    input.needle = needle_;
    const Vec3 axis(1.0, 0.0, 0.0), y(0, 1, 0);
    constexpr double kDepth_m = 0.030;  // below the face
    input.patient_from_needle =
        Pose{glm::quat_cast(glm::dmat3(y, glm::cross(axis, y), axis)), Vec3(0.0, 0.0, 0.002 + kDepth_m)};
    const test::Scan scan =
        test::scan(test::ScanMethod::serial, package, test::mirrorTable(), input, settings, probe);
    const auto peakOf = [&](int line, double from_m, double to_m) {
        int best = int(from_m / scan.bin_m);
        for (int j = best; j <= int(to_m / scan.bin_m); ++j)
            if (scan.at(line, j) > scan.at(line, best)) best = j;
        return best;
    };
    const int line = 3 * scan.lines / 4;
    const int shaft = peakOf(line, kDepth_m - 0.003, kDepth_m + 0.004);
    // The fourth echo behind the shaft.
    const double fourth_m = shaft * scan.bin_m + 4.0 * needle_.outer_m;
    const int echo = peakOf(line, fourth_m - 0.4 * needle_.outer_m, fourth_m + 0.4 * needle_.outer_m);
    EXPECT_NEAR((echo - shaft) * scan.bin_m / 4.0, needle_.outer_m, scan.bin_m);
    // The tip is in the middle of the picture.
    const double pitch_m = probe.width_m / (scan.lines - 1);
    int first = scan.lines;
    for (int l = scan.lines - 1; l >= 0; --l)
        if (scan.at(l, shaft) > 0.5 * scan.at(line, shaft)) first = l;
    const double first_m = first * pitch_m - 0.5 * probe.width_m;
    EXPECT_NEAR(first_m, 0.0, needle_.radius_m() + 2.0 * pitch_m);
}

// A needle that enters the skin leaves a hole of its own size, centred where the tip entered. The hole's edge
// is where its brightness rises most steeply.
void expectHole(const NeedleShape& needle, render::VolumePath path) {
    constexpr double kAway_m = 0.20, kSkin_m = 0.020;
    constexpr float kHalf = 0.02f;
    const double pixel_m = 2.0 * (kAway_m - kSkin_m) * std::tan(kHalf) / kPixels;
    test::PatientRenderer shown(test::makeBlock(patient::Tissue::skin, Vec3(0.04), 0.001),
                                {.ray_step_voxels = 0.5f, .close_up = false, .volume_path = path});
    WoundLog log(0.001);
    log.setNeedleRadius(needle.radius_m());
    haptics::TickOutput tick;
    tick.phase = haptics::Phase::pass;
    tick.tissue = patient::Tissue::soft;
    tick.tip_reference_m = {0.0005, -0.0003, kSkin_m};
    log.update(tick);
    const std::vector<render::Mark> marks = makeMarks(log.wounds(), render::Look::reveal, {});
    ASSERT_EQ(marks.size(), 1u);
    render::RenderScene scene;
    scene.table = false;
    scene.look = render::Look::closed;
    scene.breath = shown.package.motion.reference;
    const render::View view = test::lookAt({0.0, 0.0, kAway_m}, {0.0, 0.0, 0.0}, kHalf);
    const render::Image without = shown.renderer.drawToImages(scene, {view, view}, kPixels, kPixels)[0];
    scene.marks = marks;
    const render::Image with = shown.renderer.drawToImages(scene, {view, view}, kPixels, kPixels)[0];
    const auto brightness = [](const render::Image& image, std::size_t pixel) {  // linear
        double sum = 0.0;
        for (std::size_t c = 0; c < 3; ++c)
            sum += std::pow(image.rgba[4 * pixel + c] / 255.0, 2.2);
        return sum;
    };
    // Darkness of the mark: centre, and profile over the distance from where the tip entered.
    constexpr double kBin_m = 0.00004;
    std::vector<double> dark(60, 0.0), count(60, 0.0);
    double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
    for (std::size_t i = 0; i < std::size_t(kPixels) * kPixels; ++i) {
        const double x = (double(i % kPixels) + 0.5 - 0.5 * kPixels) * pixel_m,
                     y = (0.5 * kPixels - double(i / kPixels) - 0.5) * pixel_m;
        const double d = std::max(0.0, 1.0 - brightness(with, i) / std::max(1e-3, brightness(without, i)));
        sum += d, sum_x += d * x, sum_y += d * y;
        const auto bin =
            std::size_t(std::hypot(x - tick.tip_reference_m.x, y - tick.tip_reference_m.y) / kBin_m);
        if (bin < dark.size()) dark[bin] += d, ++count[bin];
    }
    ASSERT_GT(sum, 0.0);
    EXPECT_NEAR(sum_x / sum, tick.tip_reference_m.x, 0.0001);
    EXPECT_NEAR(sum_y / sum, tick.tip_reference_m.y, 0.0001);
    const auto at = [&](std::size_t bin) { return dark[bin] / std::max(1.0, count[bin]); };
    std::size_t steepest = 1;
    for (std::size_t b = 1; b + 1 < dark.size(); ++b)
        if (at(b - 1) - at(b + 1) > at(steepest - 1) - at(steepest + 1)) steepest = b;
    EXPECT_NEAR(2.0 * (double(steepest) + 0.5) * kBin_m, needle.outer_m, 0.0002);
}

TEST_P(NeedlePictures, Wound) {
    for (const auto path : {render::VolumePath::gpu, render::VolumePath::processor}) {
        SCOPED_TRACE(int(path));
        expectHole(needle_, path);
    }
}

// The face that is felt is the face that is seen: an instrument refers to its acoustic part.
TEST(ProbeInstruments, TheFaceHasTheShapeOfItsTransducer) {
    const auto read = [](const char* name) {
        return haptics::loadInstrument(test::assetsFolder() / "instruments" / (std::string(name) + ".toml"));
    };
    for (const char* name : {"probe-convex", "probe-linear"}) {
        const haptics::Instrument probe = read(name);
        const auto& face = std::get<haptics::ProbeSettings>(probe.force);
        const render::Transducer seen =
            render::loadTransducer(test::assetsFolder() / "ultrasound" / (probe.transducer + ".toml"));
        const render::Transducer fitted = render::withFace(seen, face.length_m, face.curvature_m);
        EXPECT_EQ(fitted.shape, seen.shape) << name;
        for (const double share : {-1.0, 0.3, 1.0}) {
            const render::ScanLine felt = scanLine(fitted, share), drawn = scanLine(seen, share);
            EXPECT_LT(glm::length(felt.origin_m - drawn.origin_m), 1e-7) << name;
            EXPECT_LT(glm::length(felt.direction - drawn.direction), 1e-6) << name;
            // What the score counts as visible, too.
            const auto start = haptics::scanLineStart(face, drawn.origin_m + 0.999 * 0.04 * drawn.direction);
            EXPECT_EQ(start.has_value(), true) << name << " " << share;
        }
    }
}

}  // namespace
}  // namespace stylet::trainer
