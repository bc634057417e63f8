// Tests the line integrals of instruments against closed forms and against rays that sample whole pixels.
#include "render/fluoroscopy/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/fluoroscopy/fluoroscopy.h"
#include "tests/render/fluoroscopy/ray_reference.h"
#include "tests/render/gpu_fixture.h"
#include "tests/support/phantom.h"

namespace stylet::render {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// Radii of the needles of 17, 18, 21 and 22 G.
constexpr std::array kRadii_m{0.00075, 0.000635, 0.00041, 0.00036};

// Air, so that a picture shows the shapes alone.
struct AirStage {
    patient::Package package = test::makeXrayPhantom(Vec3(0.05), 0.005, [](const Vec3&) { return -1000.0; });
    patient::Patient patient{package};
    Gpu gpu{{.validation = true}};
    DeformedPatient deformed{gpu, patient};
    Fluoroscopy fluoroscopy{gpu, deformed};
    FluoroscopyInput input;
    FluoroscopySettings settings;

    AirStage() {
        deformed.breathe(package.motion.reference, true);
        input.pedal = true;
        settings.beyond_ends_m = 0.0;
    }
    ~AirStage() { EXPECT_EQ(gpu.validationMessages(), 0u); }

    std::vector<double> paths() {
        EXPECT_EQ(fluoroscopy.image(input, settings).reason, "");
        input.time_s += 1.0;
        return {fluoroscopy.paths().begin(), fluoroscopy.paths().end()};
    }
    test::ShaftErrors errors(double radius_m, double turned_rad, double tilted_rad) {
        const auto draw = [&](const XrayShape& shape) {
            input.shapes = {&shape, 1};
            return paths();
        };
        return test::shaftErrors(draw, settings, radius_m, turned_rad, tilted_rad);
    }
};

// Distance of a ray from the axis of a shape, extended to both sides.
double distanceToLine_m(const XrayShape& shape, const test::XrayLine& line) {
    const Vec3 across = glm::cross(line.pixel_m - line.source_m, shape.end_m - shape.begin_m);
    return std::fabs(glm::dot(line.source_m - shape.begin_m, glm::normalize(across)));
}

// True for rays that pass within a millimetre of the end of a shape.
bool isAtEnd(const std::vector<XrayShape>& shapes, const test::XrayLine& line) {
    const Vec3 d = glm::normalize(line.pixel_m - line.source_m);
    return std::ranges::any_of(shapes, [&](const XrayShape& shape) {
        const Vec3 u = glm::normalize(shape.end_m - shape.begin_m);
        const auto along_m = [&](const Vec3& end_m) {  // of the ray's nearest point on the axis, from `end_m`
            const Vec3 from = line.source_m - end_m, across = glm::cross(d, u);
            return glm::dot(glm::cross(from, d), across) / -glm::dot(across, across);
        };
        // A thick shape's end is seen as a disc.
        const double margin_m = 0.001 + 1.5 * shape.radius_m;
        return std::fabs(along_m(shape.begin_m)) < margin_m || std::fabs(along_m(shape.end_m)) < margin_m;
    });
}

class ShapesTest : public test::GpuFixture<> {};

TEST_F(ShapesTest, MatchChordLengths) {
    AirStage stage;
    stage.settings.pixels = 65;          // odd, so that one pixel is in the centre
    stage.settings.detector_m = 0.0065;  // pixels far below the radii
    const std::size_t middle = 32 * 65 + 32;
    const auto measurePath = [&](const std::vector<XrayShape>& shapes) {
        stage.input.shapes = shapes;
        return stage.paths()[middle];
    };
    constexpr double r = 0.00075, mu = kSteelPerM;
    // Perpendicular to the ray, at 30 degrees, along it with round and with flat ends, a tube, a chain.
    EXPECT_NEAR(measurePath({{.begin_m = {-0.1, 0, 0}, .end_m = {0.1, 0, 0}, .radius_m = r}}), mu * 2 * r,
                1e-3 * mu * 2 * r);
    const Vec3 slanted(0.05, 0.05 * std::sqrt(3.0), 0.0);
    EXPECT_NEAR(measurePath({{.begin_m = -slanted, .end_m = slanted, .radius_m = r}}), mu * 4 * r,
                1e-3 * mu * 4 * r);
    EXPECT_NEAR(measurePath({{.begin_m = {0, -0.02, 0}, .end_m = {0, 0.03, 0}, .radius_m = r}}),
                mu * (0.05 + 2 * r), 1e-4 * mu);
    EXPECT_NEAR(
        measurePath({{.begin_m = {0, -0.02, 0}, .end_m = {0, 0.03, 0}, .radius_m = r, .round = false}}),
        mu * 0.05, 1e-4 * mu);
    EXPECT_NEAR(
        measurePath({{.begin_m = {-0.1, 0, 0}, .end_m = {0.1, 0, 0}, .radius_m = r, .bore_m = 0.4 * r}}),
        mu * 1.2 * r, 2e-3 * mu * 1.2 * r);
    EXPECT_NEAR(measurePath({{.begin_m = {0, 0, 0}, .end_m = {0, 0, 0}, .radius_m = 0.004}}), mu * 0.008,
                1e-3 * mu * 0.008);
    EXPECT_NEAR(measurePath({{.begin_m = {-0.1, 0, 0}, .end_m = {0, 0, 0}, .radius_m = r},
                             {.begin_m = {0, 0, 0}, .end_m = {0.1, 0, 0}, .radius_m = r, .chained = true}}),
                mu * 2 * r, 1e-3 * mu * 2 * r);
    // Beside the ray, behind the detector, and before the source.
    EXPECT_EQ(measurePath({{.begin_m = {-0.1, 0, 0.001}, .end_m = {0.1, 0, 0.001}, .radius_m = r}}), 0.0);
    EXPECT_EQ(measurePath({{.begin_m = {-0.1, 0.5, 0}, .end_m = {0.1, 0.5, 0}, .radius_m = r}}), 0.0);
    EXPECT_EQ(measurePath({{.begin_m = {-0.1, -0.8, 0}, .end_m = {0.1, -0.8, 0}, .radius_m = r}}), 0.0);
}

// Compares every pixel of a slanted needle with the mean over many rays through the pixel.
// HZ-TEACH-05
TEST_F(ShapesTest, NeedleProjectsToItsPosition) {
    constexpr int kFine = 16, kPixels = 384;
    AirStage stage;
    stage.settings.pixels = kPixels;
    std::vector<XrayShape> shapes;
    addNeedle({glm::angleAxis(1.1, glm::normalize(Vec3(0.3, 1.0, 0.2))), {0.01, 0.02, -0.01}}, NeedleShape(),
              false, shapes);
    stage.input.shapes = shapes;
    const std::vector<double> paths = stage.paths();
    const double densest = *std::ranges::max_element(paths), side_m = stage.settings.detector_m;
    double sum = 0.0, expected_sum = 0.0;
    int compared = 0;
    for (int i = 0; i < kPixels * kPixels; ++i) {
        const test::XrayLine line = test::xrayLine(stage.input, i % kPixels, i / kPixels, kPixels, side_m);
        const double away_m = distanceToLine_m(shapes[0], line);
        if (away_m > 0.008) {
            ASSERT_EQ(paths[std::size_t(i)], 0.0) << i;
            continue;
        }
        double expected = 0.0;
        for (int k = 0; k < kFine * kFine; ++k) {
            const test::XrayLine ray =
                test::xrayLine(stage.input, i % kPixels * kFine + k % kFine, i / kPixels * kFine + k / kFine,
                               kPixels * kFine, side_m);
            for (const XrayShape& shape : shapes)
                expected += test::shaftPath(shape, ray) / (kFine * kFine);
        }
        sum += paths[std::size_t(i)], expected_sum += expected;
        // The footprint is averaged across a shaft, not along it: its end is one pixel early or late.
        if (isAtEnd(shapes, line)) continue;
        ASSERT_NEAR(paths[std::size_t(i)], expected, 0.03 * densest) << i;
        if (expected > 0.1 * densest) ++compared;
    }
    EXPECT_GT(compared, 300);
    EXPECT_NEAR(sum, expected_sum, 0.01 * expected_sum);
}

// A needle is thinner than one or two pixels. The attenuation across its shaft is that of its steel, and its
// densest pixel hardly depends on where it lies between the pixels.
TEST_F(ShapesTest, ThinShaftsKeepTheirAttenuationAtEverySubPixelPosition) {
    AirStage stage;
    for (const int pixels : {256, 384})  // of the trainer: on a processor, on a GPU
        for (const double radius_m : kRadii_m)
            for (const auto& [turned_deg, tilted_deg] : {std::pair{0.0, 0.0},
                                                         {10.0, 0.0},
                                                         {30.0, 0.0},
                                                         {45.0, 0.0},
                                                         {80.0, 0.0},
                                                         {90.0, 0.0},
                                                         {20.0, 40.0}}) {
                SCOPED_TRACE(testing::Message() << pixels << " pixels, radius " << radius_m << " m, turned "
                                                << turned_deg << ", tilted " << tilted_deg);
                stage.settings.pixels = pixels;
                const test::ShaftErrors errors =
                    stage.errors(radius_m, turned_deg * kDegree, tilted_deg * kDegree);
                EXPECT_LT(errors.area, 0.01);
                EXPECT_LT(errors.flicker, 0.15);
            }
}

// A tube keeps the attenuation of its wall, and a needle seen end-on that of its whole length.
TEST_F(ShapesTest, ThinTubesAndEndOnShaftsKeepTheirAttenuation) {
    AirStage stage;
    constexpr double kOuter_m = 0.00036, kBore_m = 0.000205, kLength_m = 0.1;
    const double pitch_m =
        stage.settings.detector_m / stage.settings.pixels * kSourceToIsocentre_m / kSourceToDetector_m;
    const double wall_m2 = std::numbers::pi * (kOuter_m * kOuter_m - kBore_m * kBore_m);
    const auto total = [&](const Vec3& half) {
        const XrayShape tube{
            .begin_m = -half, .end_m = half, .radius_m = kOuter_m, .bore_m = kBore_m, .round = false};
        stage.input.shapes = {&tube, 1};
        double sum = 0.0;
        for (const double path : stage.paths())
            sum += path * pitch_m * pitch_m;
        return sum;
    };
    const double volume_m3 = wall_m2 * kLength_m;
    EXPECT_NEAR(total({0.5 * kLength_m, 0.0, 0.0}), kSteelPerM * volume_m3, 0.01 * kSteelPerM * volume_m3);
    // Nearly along the beam the picture of a shaft is a dot, whose pixels see much of its length.
    const double slight = 3.0 * kDegree;
    const double along = total(0.5 * kLength_m * Vec3(std::sin(slight), std::cos(slight), 0.0));
    EXPECT_NEAR(along, kSteelPerM * volume_m3, 0.1 * kSteelPerM * volume_m3);
}

}  // namespace
}  // namespace stylet::render
