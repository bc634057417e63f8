// Tests the GPU's line integrals against closed forms and the naive reference, and their display on the
// screen.
#include "render/fluoroscopy/fluoroscopy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "patient/contrast/contrast.h"
#include "patient/synth/synth.h"
#include "tests/render/fluoroscopy/ray_reference.h"
#include "tests/render/gpu_fixture.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/support/constants.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::render {
namespace {

using patient::Package;
using patient::Patient;
using test::kNaN;

constexpr double kMuWater = 19.3;

struct Stage {
    Package package;
    Patient patient{package};
    Gpu gpu{{.validation = true}};
    DeformedPatient deformed{gpu, patient};
    Fluoroscopy fluoroscopy{gpu, deformed};
    FluoroscopyInput input;
    FluoroscopySettings settings;
    FluoroscopyStats stats;

    explicit Stage(Package p) : package(std::move(p)) {
        deformed.breathe(package.motion.reference, true);
        input.pedal = true;
        settings.pixels = 64;
        settings.beyond_ends_m = 0.0;
        settings.count = true;
    }
    ~Stage() { EXPECT_EQ(gpu.validationMessages(), 0u); }

    std::vector<double> paths() {
        stats = fluoroscopy.image(input, settings);
        EXPECT_EQ(stats.reason, "");
        input.time_s += 1.0;
        return {fluoroscopy.paths().begin(), fluoroscopy.paths().end()};
    }
    test::XrayLine line(std::size_t pixel) const {
        return test::xrayLine(input, int(pixel) % settings.pixels, int(pixel) / settings.pixels,
                              settings.pixels, settings.detector_m);
    }
    template <typename Path>
    std::vector<double> reference(const Path& path) const {
        std::vector<double> found;
        for (std::size_t i = 0; i < std::size_t(settings.pixels) * std::size_t(settings.pixels); ++i)
            found.push_back(path(line(i)));
        return found;
    }
    std::vector<std::uint8_t> greys() const {
        const ScreenPicture p = fluoroscopy.picture();
        std::vector<std::uint8_t> found;
        for (int i = 0; i < p.width * p.height; ++i)
            found.push_back(p.rgba[4 * i]);
        return found;
    }
};

class FluoroscopyTest : public test::GpuFixture<> {};

// From air to water over `depth_m` >= 0, with an edge two voxels wide, as a scanner records it.
double softEdge(double depth_m, double voxel_m) {
    return -1000.0 * (1.0 - std::clamp(0.5 + depth_m / (2.0 * voxel_m), 0.0, 1.0));
}

Package makeAir() {
    return test::makeXrayPhantom(Vec3(0.05), 0.005, [](const Vec3&) { return -1000.0; });
}

TEST_F(FluoroscopyTest, SlabIsExact) {
    Stage stage(test::makeXrayPhantom({0.15, 0.05, 0.15}, 0.002, [](const Vec3&) { return 100.0; }));
    for (const double voxel_m : {0.002, 0.0035}) {
        stage.settings.voxel_m = voxel_m;
        const std::vector<double> paths = stage.paths();
        for (std::size_t i = 0; i < paths.size(); ++i) {
            const test::XrayLine line = stage.line(i);
            const Vec3 d = glm::normalize(line.pixel_m - line.source_m);
            const double expected = kMuWater * 1.1 * 0.1 / d.y;
            ASSERT_NEAR(paths[i], expected, 1e-3 * expected) << i;
        }
    }
}

// Steps no longer than a voxel represent faces exactly. Longer steps add noise around the true value.
TEST_F(FluoroscopyTest, SlabInAirIsExact) {
    Stage stage(test::makeXrayPhantom({0.12, 0.06, 0.12}, 0.002, [](const Vec3& p) {
        return std::fabs(p.y) < 0.04 && std::fabs(p.x) < 0.1 && std::fabs(p.z) < 0.1 ? 0.0 : -1000.0;
    }));
    for (const double step_m : {0.001, 0.002, 0.004}) {
        stage.settings.step_m = step_m;
        const std::vector<double> paths = stage.paths();
        double sum = 0.0, sum_expected = 0.0;
        // Only where the rays pass through both faces.
        for (int row = 10; row < 54; ++row)
            for (int column = 10; column < 54; ++column) {
                const std::size_t i = std::size_t(row * 64 + column);
                const Vec3 d = glm::normalize(stage.line(i).pixel_m - stage.line(i).source_m);
                const double expected = kMuWater * 0.08 / d.y;
                ASSERT_NEAR(paths[i], expected, (step_m > 0.002 ? 2e-2 : 1e-3) * expected)
                    << column << " " << row;
                sum += paths[i], sum_expected += expected;
            }
        EXPECT_NEAR(sum, sum_expected, 1e-3 * sum_expected);
    }
}

TEST_F(FluoroscopyTest, SphereMatchesChordLengths) {
    constexpr double kRadius_m = 0.06;
    Stage stage(test::makeXrayPhantom(
        Vec3(0.063), 0.001, [](const Vec3& p) { return softEdge(kRadius_m - glm::length(p), 0.001); }));
    stage.settings.step_m = 0.0005;
    for (const double orbital_rad : {0.0, 0.7}) {
        stage.input.arm.orbital_rad = orbital_rad;
        const std::vector<double> paths = stage.paths();
        double worst = 0.0;
        for (std::size_t i = 0; i < paths.size(); ++i) {
            const test::XrayLine line = stage.line(i);
            const Vec3 d = glm::normalize(line.pixel_m - line.source_m);
            const double off = glm::length(line.source_m - glm::dot(line.source_m, d) * d);
            if (off > 0.6 * kRadius_m) continue;
            const double chord = 2.0 * std::sqrt(kRadius_m * kRadius_m - off * off);
            worst = std::max(worst, std::fabs(paths[i] / (kMuWater * chord) - 1.0));
        }
        EXPECT_LT(worst, 1e-3) << orbital_rad;
    }
}

// A wedge whose thickness grows linearly along x.
TEST_F(FluoroscopyTest, WedgeRisesLinearly) {
    Stage stage(test::makeXrayPhantom({0.13, 0.06, 0.04}, 0.002, [](const Vec3& p) {
        return std::min(softEdge(0.3 * p.x - p.y, 0.002), softEdge(p.y + 0.05, 0.002));
    }));
    stage.settings.step_m = 0.001;
    const std::vector<double> paths = stage.paths();
    for (int column = 8; column < 56; ++column) {
        const std::size_t i = std::size_t(32 * 64 + column);
        const test::XrayLine line = stage.line(i);
        const Vec3 way = line.pixel_m - line.source_m;
        // From the plane y = -0.05 to the plane y = 0.3 x.
        const double enters = (-0.05 - line.source_m.y) / way.y;
        const double leaves = (0.3 * line.source_m.x - line.source_m.y) / (way.y - 0.3 * way.x);
        const double expected = kMuWater * (leaves - enters) * glm::length(way);
        EXPECT_NEAR(paths[i], expected, 1e-3 * kMuWater * 0.08) << column;
    }
}

// A cube of contrast medium in air appears, fades, moves and disappears.
TEST_F(FluoroscopyTest, ContrastFollowsItsTable) {
    Stage stage(makeAir());
    stage.settings.pixels = 65;
    const auto cubeAt = [](const Index3& low, float added, std::uint64_t revision) {
        const Grid ct = makeAir().ct.grid;
        patient::ContrastTable table{{Index3(6), ct.spacing_m, ct.centre(low)}, {}, revision};
        for (int n = 0; n < 216; ++n) {
            const Index3 i(n % 6, n / 6 % 6, n / 36);
            const bool within =
                glm::all(glm::greaterThan(i, Index3(0))) && glm::all(glm::lessThan(i, Index3(5)));
            table.added_per_m.push_back(within ? added : 0.0f);
        }
        return table;
    };
    // A cube of 4 voxels, 20 mm, per side. The centre ray passes through 20 mm of it.
    const auto middle = [&] { return stage.paths()[32 * 65 + 32]; };
    patient::ContrastTable table = cubeAt({7, 7, 7}, 60.0f, 1);
    stage.input.contrast = &table;
    EXPECT_NEAR(middle(), 1.2, 3e-3);
    EXPECT_EQ(stage.stats.unchanged_contrast, 0);
    EXPECT_NEAR(middle(), 1.2, 3e-3);
    EXPECT_EQ(stage.stats.unchanged_contrast, 1);
    // Coarser voxels spread the contrast medium but keep its total.
    const auto sumPaths = [](const std::vector<double>& paths) {
        return std::accumulate(paths.begin(), paths.end(), 0.0);
    };
    stage.settings.pixels = 256;
    const double fine = sumPaths(stage.paths());
    stage.settings.voxel_m = 0.0125;
    EXPECT_NEAR(sumPaths(stage.paths()), fine, 0.005 * fine);
    stage.settings.pixels = 65;
    EXPECT_LT(middle(), 1.0);
    stage.settings.voxel_m = 0.005;
    table = cubeAt({7, 7, 7}, 30.0f, 2);
    EXPECT_NEAR(middle(), 0.6, 1.5e-3);
    table = cubeAt({1, 7, 1}, 30.0f, 3);  // toward the patient's left and feet
    EXPECT_EQ(middle(), 0.0);
    const std::vector<double> moved = stage.paths();
    double right = 0.0, down = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < moved.size(); ++i)
        sum += moved[i], right += moved[i] * (double(i % 65) - 32.0),
            down += moved[i] * (double(i / 65) - 32.0);
    EXPECT_GT(right, 5.0 * sum);
    EXPECT_GT(down, 5.0 * sum);
    stage.settings.skips.unchanged_contrast = false;
    EXPECT_EQ(stage.paths(), moved);
    EXPECT_EQ(stage.stats.unchanged_contrast, 0);
    stage.input.contrast = nullptr;
    for (const double path : stage.paths())
        ASSERT_EQ(path, 0.0);
    const patient::ContrastTable none;
    stage.input.contrast = &none;
    EXPECT_EQ(middle(), 0.0);
}

// The synthetic patient: compared voxel-exactly at rest, and by fine sampling while breathing and pressed.
class FluoroscopyPatientTest : public FluoroscopyTest {
  protected:
    static const Package& package() {
        static const Package made = [] {
            patient::synth::SynthSettings settings;
            settings.spacing_m = 0.0025;
            settings.defaults = test::tissueDefaults();
            return test::finerCt(patient::synth::makeReferencePatient(settings));
        }();
        return made;
    }
    static FluoroscopyInput overLiver() {
        FluoroscopyInput input;
        input.pedal = true;
        input.patient_from_isocentre.position_m = {0.03, 0.0, 0.05};
        return input;
    }
    // A ball of tissue in the liver, moved aside. Static, because the table must outlive its users.
    static const patient::DisplacementTable& pressed() {
        static const patient::DisplacementTable made = [] {
            patient::DisplacementTable table;
            table.grid = {Index3(21), Vec3(0.003), Vec3(0.03, -0.03, 0.02)};
            for (int n = 0; n < 21 * 21 * 21; ++n) {
                const Vec3 at = Vec3(n % 21, n / 21 % 21, n / 441) / 10.0 - 1.0;
                const double bump = std::max(0.0, 1.0 - glm::dot(at, at));
                table.moved_m.emplace_back(0.004 * bump, 0.0, 0.006 * bump, 0.0);
            }
            return table;
        }();
        return made;
    }
    // A slanted, filled duct of about 7 mm in the liver, in a box of the CT's own voxels.
    static patient::ContrastTable duct() {
        const Grid& ct = package().ct.grid;
        patient::ContrastTable table;
        table.grid = {Index3(40, 32, 48), ct.spacing_m, ct.centre(ct.nearest({0.035, -0.02, 0.02}))};
        const Vec3 middle = table.grid.centre({20, 16, 24}), u = glm::normalize(Vec3(0.3, 0.4, 1.0));
        for (int n = 0; n < 40 * 32 * 48; ++n) {
            const Vec3 p = table.grid.centre({n % 40, n / 40 % 32, n / 1280}) - middle;
            const double away_mm = 1e3 * glm::length(p - glm::dot(p, u) * u);
            table.added_per_m.push_back(float(75.0 * std::clamp(4.0 - away_mm, 0.0, 1.0)));
        }
        table.revision = 1;
        return table;
    }
};

TEST_F(FluoroscopyPatientTest, AgreesWithExactRaySums) {
    Stage stage(package());
    stage.input = overLiver();
    for (const CArm& arm :
         {CArm{}, CArm{.orbital_rad = 0.5, .angulation_rad = 0.3}, CArm{.orbital_rad = -1.57}}) {
        stage.input.arm = arm;
        const std::vector<double> exact =
            stage.reference([&](const auto& line) { return test::exactPath(stage.package.ct, line); });
        const std::vector<double> paths = stage.paths();
        EXPECT_EQ(stage.stats.still_pictures, 1);
        EXPECT_GE(test::zncc(exact, paths), 0.9999) << arm.orbital_rad;
        EXPECT_GE(test::pathPsnr(exact, paths), 45.0) << arm.orbital_rad;
    }
}

// HZ-TEACH-15
TEST_F(FluoroscopyPatientTest, AgreesWithFineSumsWithBreathToolAndContrast) {
    Stage stage(package());
    stage.input = overLiver();
    stage.settings.pixels = 48;
    stage.settings.block = 1;  // no sharing, because pixels are far apart here
    stage.settings.beyond_ends_m = 0.1;
    const patient::ContrastTable contrast = duct();
    stage.input.contrast = &contrast;
    const patient::Surrogate breath{.v = stage.package.motion.reference.v + 0.9};
    stage.deformed.breathe(breath, false);
    stage.deformed.press(&pressed());
    const auto fine = [&](const patient::Surrogate& b, const patient::DisplacementTable* tool,
                          const patient::ContrastTable* added) {
        return stage.reference([&](const auto& line) {
            return test::finePath({.package = &stage.package,
                                   .breath = b,
                                   .tool = tool,
                                   .contrast = added,
                                   .beyond_ends_m = 0.1,
                                   .step_m = 0.00047},
                                  line);
        });
    };
    const std::vector<double> paths = stage.paths();
    EXPECT_EQ(stage.stats.still_pictures + stage.stats.idle_tool_pictures + stage.stats.unchanged_contrast,
              0);
    EXPECT_GE(test::zncc(fine(breath, &pressed(), &contrast), paths), 0.9999);
    // Each effect must be visible: leaving it out must change the picture.
    const double without_breath =
        test::zncc(fine(stage.package.motion.reference, &pressed(), &contrast), paths);
    const double without_tool = test::zncc(fine(breath, nullptr, &contrast), paths);
    const double without_contrast = test::zncc(fine(breath, &pressed(), nullptr), paths);
    EXPECT_LT(without_breath, 0.999);
    EXPECT_LT(without_tool, 0.9998);
    EXPECT_LT(without_contrast, 0.9995);
}

TEST_F(FluoroscopyPatientTest, SkipsChangeTheWorkButNotThePicture) {
    Stage stage(package());
    stage.input = overLiver();
    stage.input.arm.orbital_rad = 0.8;
    stage.input.collimation = {.left_m = 0.08, .right_m = 0.10, .up_m = 0.12, .down_m = 0.06, .iris_m = 0.11};
    stage.settings.beyond_ends_m = 0.1;
    struct XrayPicture {
        std::vector<std::uint8_t> greys;
        FluoroscopyStats stats;
    };
    const auto pictureWith = [&](const FluoroscopySkips& skips) {
        stage.settings.skips = skips;
        stage.input.time_s = 3.0;
        const FluoroscopyStats stats = stage.fluoroscopy.image(stage.input, stage.settings);
        return XrayPicture{stage.greys(), stats};
    };
    const XrayPicture all = pictureWith({.between_pulses = false});
    EXPECT_GT(all.stats.collimated_rays, 0u);
    EXPECT_GT(all.stats.empty_segments, 0u);
    EXPECT_EQ(all.stats.still_pictures, 1);
    EXPECT_EQ(all.stats.idle_tool_pictures, 1);
    EXPECT_EQ(all.stats.unchanged_contrast, 1);
    const auto differ = [&](const XrayPicture& other) {
        int most = 0;
        for (std::size_t i = 0; i < all.greys.size(); ++i)
            most = std::max(most, std::abs(int(all.greys[i]) - int(other.greys[i])));
        return most;
    };
    const XrayPicture no_collimation = pictureWith({.between_pulses = false, .collimated_rays = false});
    EXPECT_EQ(differ(no_collimation), 0);
    EXPECT_EQ(no_collimation.stats.collimated_rays, 0u);
    EXPECT_GT(no_collimation.stats.samples, all.stats.samples);
    const XrayPicture no_cells = pictureWith({.between_pulses = false, .empty_cells = false});
    EXPECT_EQ(differ(no_cells), 0);
    EXPECT_EQ(no_cells.stats.empty_segments, 0u);
    EXPECT_GT(no_cells.stats.samples, all.stats.samples);
    stage.deformed.breathe(stage.package.motion.reference, false);
    const XrayPicture no_still = pictureWith({.between_pulses = false});
    EXPECT_LE(differ(no_still), 1);
    EXPECT_EQ(no_still.stats.still_pictures, 0);
    stage.deformed.breathe(stage.package.motion.reference, true);
    const XrayPicture no_idle = pictureWith({.between_pulses = false, .idle_tool = false});
    EXPECT_EQ(differ(no_idle), 0);
    EXPECT_EQ(no_idle.stats.idle_tool_pictures, 0);
    // The picture of a pulse is computed only once.
    const XrayPicture kept = pictureWith({});
    EXPECT_EQ(kept.stats.reused_pulses, 1);
    EXPECT_EQ(differ(kept), 0);
    EXPECT_FALSE(kept.stats.live);
    EXPECT_EQ(kept.stats.exposure.dose_area_gy_m2, 0.0);
}

TEST_F(FluoroscopyPatientTest, EmptyCellsStayEmptyWithBreathToolAndContrast) {
    Stage stage(package());
    stage.input = overLiver();
    const patient::ContrastTable contrast = duct();
    stage.input.contrast = &contrast;
    stage.deformed.breathe({.v = stage.package.motion.reference.v + 1.2}, false);
    stage.deformed.press(&pressed());
    for (const CArm& arm : {CArm{}, CArm{.orbital_rad = 0.8, .angulation_rad = -0.3}}) {
        stage.input.arm = arm;
        stage.settings.skips.empty_cells = true;
        const std::vector<double> with = stage.paths();
        EXPECT_GT(stage.stats.empty_segments, 0u);
        stage.settings.skips.empty_cells = false;
        EXPECT_EQ(with, stage.paths());
    }
}

TEST_F(FluoroscopyPatientTest, LastImageIsHeldWhenThePedalIsUp) {
    Stage stage(package());
    stage.input = overLiver();
    stage.input.pedal = false;
    stage.settings.pulse_rate_hz = 10.0;
    FluoroscopyStats stats = stage.fluoroscopy.image(stage.input, stage.settings);
    EXPECT_FALSE(stats.last_image_held);
    EXPECT_FALSE(stats.reason.empty());
    EXPECT_EQ(stage.fluoroscopy.picture().width, 64);
    stage.input.pedal = true;
    stage.input.time_s = 0.35;
    stats = stage.fluoroscopy.image(stage.input, stage.settings);
    EXPECT_TRUE(stats.live);
    EXPECT_EQ(stats.pulse, 3);
    EXPECT_GT(stats.exposure.dose_area_gy_m2, 0.0);
    const std::vector<std::uint8_t> shown = stage.greys();
    const std::uint64_t revision = stage.fluoroscopy.picture().revision;
    // Breathing, time and the detector's settings change. The picture on the screen must not.
    stage.deformed.breathe({.v = stage.package.motion.reference.v + 1.0}, false);
    stage.input.pedal = false;
    stage.input.time_s = 0.75;
    stage.settings.pixels = 32;
    stats = stage.fluoroscopy.image(stage.input, stage.settings);
    EXPECT_TRUE(stats.last_image_held);
    EXPECT_FALSE(stats.live);
    EXPECT_EQ(stats.pedal_up, 1);
    EXPECT_EQ(stats.pulse, 3);
    EXPECT_EQ(stats.exposure.reference_kerma_gy, 0.0);
    EXPECT_EQ(stage.greys(), shown);
    EXPECT_EQ(stage.fluoroscopy.picture().revision, revision);
    stage.input.pedal = true;
    stage.settings.pixels = 64;
    EXPECT_TRUE(stage.fluoroscopy.image(stage.input, stage.settings).live);
    EXPECT_NE(stage.greys(), shown);
}

TEST_F(FluoroscopyTest, NoiseMatchesQuantumStatistics) {
    Stage stage(test::makeXrayPhantom({0.16, 0.1, 0.16}, 0.004, [](const Vec3&) { return 0.0; }));
    stage.settings.flattening = 0.0;
    stage.settings.pixels = 128;
    for (const double dose : {10e-9, 40e-9}) {
        stage.settings.dose.detector_kerma_gy = dose;
        stage.paths();
        const double quanta = stage.stats.exposure.quanta_per_pixel * stage.stats.exposure.transmission;
        EXPECT_NEAR(quanta, dose * kPhotonsPerM2Gy * kDetectedShare * 0.3 * 0.3 / (128.0 * 128.0),
                    1e-6 * quanta);
        // grey = s^g / (1 + s^g), so s = (grey / (1 - grey))^(1/g): quanta relative to mid-grey.
        const std::vector<std::uint8_t> greys = stage.greys();
        double sum = 0.0, squares = 0.0;
        int count = 0;
        for (int row = 44; row < 84; ++row)
            for (int column = 44; column < 84; ++column) {
                const double grey = greys[std::size_t(row * 128 + column)] / 255.0;
                const double s = std::pow(grey / (1.0 - grey), 1.0 / stage.settings.curve);
                sum += s, squares += s * s, ++count;
            }
        const double mean = sum / count, deviation = std::sqrt(squares / count - mean * mean);
        const double e = stage.settings.electronic_quanta;
        EXPECT_NEAR(mean, 1.0, 0.02) << dose;
        EXPECT_NEAR(deviation, std::sqrt(quanta + e * e) / quanta, 0.08 * std::sqrt(quanta + e * e) / quanta)
            << dose;
    }
}

// The meter uses the middle of the open field, for any number of pixels.
TEST_F(FluoroscopyTest, ExposureMetersTheMiddleOfTheOpenField) {
    Stage stage(test::makeXrayPhantom({0.16, 0.1, 0.16}, 0.004,
                                      [](const Vec3& p) { return p.x > 0.0 ? 0.0 : -500.0; }));
    const double thick = std::exp(-kMuWater * 0.2), thin = std::exp(-kMuWater * 0.1);
    for (const int pixels : {31, 64, 100, 130, 256}) {
        stage.settings.pixels = pixels;
        stage.input.collimation = {};
        stage.paths();
        EXPECT_NEAR(std::log(stage.stats.exposure.transmission), 0.5 * std::log(thick * thin), 0.1) << pixels;
        // The patient's right is on the left side of the picture.
        stage.input.collimation = {.right_m = -0.02};
        stage.paths();
        EXPECT_NEAR(std::log(stage.stats.exposure.transmission), std::log(thick), 0.1) << pixels;
        stage.input.collimation = {.left_m = -0.02};
        stage.paths();
        EXPECT_NEAR(std::log(stage.stats.exposure.transmission), std::log(thin), 0.1) << pixels;
    }
}

TEST_F(FluoroscopyTest, NoiseDependsOnPulseAndSeedOnly) {
    Stage stage(test::makeXrayPhantom({0.16, 0.05, 0.16}, 0.004, [](const Vec3&) { return 0.0; }));
    const auto greysAt = [&](double time_s, std::uint32_t seed) {
        stage.input.time_s = time_s;
        stage.settings.seed = seed;
        EXPECT_TRUE(stage.fluoroscopy.image(stage.input, stage.settings).live);
        return stage.greys();
    };
    const auto first = greysAt(1.0, 1);
    const auto second = greysAt(2.0, 1);
    EXPECT_NE(second, first);
    EXPECT_EQ(greysAt(1.0, 1), first);
    greysAt(2.0, 1);
    EXPECT_NE(greysAt(1.0, 2), first);
}

// HZ-TEACH-04
TEST_F(FluoroscopyTest, DenseIsDarkAndPatientLeftIsOnTheRight) {
    // Lead toward the patient's left and head.
    Stage stage(test::makeXrayPhantom({0.12, 0.05, 0.12}, 0.004, [](const Vec3& p) {
        return p.x < -0.03 && p.x > -0.06 && p.z > 0.03 && p.z < 0.06 ? 3000.0 : 0.0;
    }));
    stage.settings.flattening = 0.0;
    stage.settings.electronic_quanta = 0.0;
    stage.paths();
    const auto greyAt = [&](double right_m, double up_m) {  // at the isocentre
        const double pixel = stage.settings.detector_m / 64 * 720.0 / 1100.0;
        const int column = int(32 + right_m / pixel), row = int(32 - up_m / pixel);
        return int(stage.greys()[std::size_t(row * 64 + column)]);
    };
    for (const auto& [right, up] : {std::pair{-0.045, 0.045}, {-0.045, -0.045}, {0.045, -0.045}})
        EXPECT_GT(greyAt(right, up), greyAt(0.045, 0.045) + 80) << right << " " << up;
    stage.settings.dense_is_dark = false;
    stage.paths();
    EXPECT_GT(greyAt(0.045, 0.045), greyAt(-0.045, 0.045) + 80);
}

// HZ-TEACH-21
TEST_F(FluoroscopyTest, InvalidInputGivesABlackPictureWithAReason) {
    Stage stage(test::makeXrayPhantom(Vec3(0.05), 0.005, [](const Vec3&) { return 0.0; }));
    const auto expectBlack = [&](const FluoroscopyInput& input, const FluoroscopySettings& settings) {
        const FluoroscopyStats stats = stage.fluoroscopy.image(input, settings);
        EXPECT_FALSE(stats.reason.empty());
        EXPECT_FALSE(stats.live);
        EXPECT_EQ(stats.exposure.dose_area_gy_m2, 0.0);
        const ScreenPicture picture = stage.fluoroscopy.picture();
        ASSERT_GT(picture.width, 0);
        for (int i = 0; i < picture.width * picture.height; ++i)
            ASSERT_EQ(picture.rgba[4 * i] + picture.rgba[4 * i + 1] + picture.rgba[4 * i + 2], 0);
    };
    const auto withInput = [&](const auto& change) {
        SCOPED_TRACE(testing::Message() << "input");
        stage.paths();  // there was a valid picture before
        FluoroscopyInput input = stage.input;
        change(input);
        expectBlack(input, stage.settings);
    };
    const std::vector<XrayShape> nowhere{{.begin_m = Vec3(kNaN)}}, thin{{.radius_m = 0.0}};
    const patient::ContrastTable torn{{Index3(4), Vec3(0.001), Vec3(0.0)}, {1.0f, 2.0f}, 1};
    withInput([](auto& in) { in.arm.orbital_rad = kNaN; });
    withInput([](auto& in) { in.patient_from_isocentre.position_m.y = kNaN; });
    withInput([](auto& in) { in.patient_from_isocentre.position_m.x = 1e300; });
    withInput([](auto& in) { in.patient_from_isocentre.rotation = {0.0, 0.0, 0.0, 0.0}; });
    withInput([](auto& in) { in.collimation.left_m = kNaN; });
    withInput([](auto& in) { in.collimation.left_m = in.collimation.right_m = 0.0; });
    withInput([](auto& in) { in.collimation.iris_m = 0.0; });
    withInput([](auto& in) { in.time_s = kNaN; });
    withInput([&](auto& in) { in.shapes = nowhere; });
    withInput([&](auto& in) { in.shapes = thin; });
    withInput([&](auto& in) { in.contrast = &torn; });
    withInput([](auto& in) { in.patient_from_isocentre.position_m = {0.0, kSourceToIsocentre_m, 0.0}; });
    withInput([](auto& in) { in.patient_from_isocentre.position_m = {0.0, -0.38, 0.0}; });
    const auto withSettings = [&](const auto& change) {
        SCOPED_TRACE(testing::Message() << "settings");
        stage.paths();
        FluoroscopySettings settings = stage.settings;
        change(settings);
        expectBlack(stage.input, settings);
    };
    withSettings([](auto& s) { s.pixels = 0; });
    withSettings([](auto& s) { s.pixels = -7; });
    withSettings([](auto& s) { s.pixels = 1 << 20; });
    withSettings([](auto& s) { s.voxel_m = 0.0; });
    withSettings([](auto& s) { s.step_m = kNaN; });
    withSettings([](auto& s) { s.step_m = 1e-12; });
    withSettings([](auto& s) { s.voxel_m = 1e300; });
    withSettings([](auto& s) { s.beyond_ends_m = 1e9; });
    withSettings([](auto& s) { s.detector_m = -0.3; });
    withSettings([](auto& s) { s.segment_m = -1.0; });
    withSettings([](auto& s) { s.pulse_rate_hz = 0.0; });
    withSettings([](auto& s) { s.block = 3; });
    // Valid settings work again.
    stage.paths();
    EXPECT_TRUE(stage.stats.live);
}

// A source beside the patient, a patient beside the beam, and a single pixel all give valid pictures.
TEST_F(FluoroscopyTest, UnusualBeamsGiveValidPictures) {
    Stage stage(test::makeXrayPhantom(Vec3(0.05), 0.005, [](const Vec3&) { return 0.0; }));
    stage.input.patient_from_isocentre.position_m = {0.4, 0.0, 0.0};
    for (const double path : stage.paths())
        ASSERT_EQ(path, 0.0);
    EXPECT_EQ(stage.stats.exposure.transmission, 1.0);
    stage.input.patient_from_isocentre.position_m = {};
    stage.settings.pixels = 1;
    EXPECT_NEAR(stage.paths()[0], kMuWater * 0.1, 1e-3);
    stage.settings.pixels = 67;
    stage.settings.block = 4;
    stage.input.collimation.iris_m = 0.01;
    const std::vector<double> paths = stage.paths();
    EXPECT_NEAR(paths[33 * 67 + 33], kMuWater * 0.1, 1e-3);
}

}  // namespace
}  // namespace stylet::render
