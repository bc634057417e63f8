// Tests the ultrasound machine: comparison with the reference, skips, rejected input, Doppler.
#include "render/ultrasound/ultrasound.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patient/contrast/vessel_flow.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"
#include "tests/render/ultrasound/scan_reference.h"
#include "tests/render/ultrasound/sound_phantoms.h"
#include "tests/support/constants.h"

namespace stylet::render {
namespace {

using test::kNaN;

// A probe at the trunk's right flank, between ribs. The picture's plane is nearly axial.
UltrasoundInput atTheFlank(double press_m = 0.006) {
    const Vec3 z(-1, 0, 0), x(0, 1, 0);
    UltrasoundInput input;
    input.patient_from_probe =
        Pose{glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)), Vec3(0.150 - press_m, 0.0, -0.015)};
    return input;
}

class UltrasoundTest : public testing::Test {
  protected:
    void SetUp() override {
        if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
        gpu.emplace(GpuSettings{.validation = true});
        deformed.emplace(*gpu, patient);
        machine.emplace(*gpu, *deformed, table);
        settings.lines = 96;
        settings.samples = 384;
        settings.noise_db = -400.0;
        settings.width = 300;
        settings.height = 240;
        breathe(0.0);
    }
    void TearDown() override {
        if (gpu) {
            EXPECT_EQ(gpu->validationMessages(), 0u);
        }
    }
    void breathe(double v) {
        patient::Surrogate now = package.motion.reference;
        now.v += v;
        deformed->breathe(now, deformed->atRest(now));
    }
    std::vector<std::uint8_t> pixels() const {
        const ScreenPicture p = machine->picture();
        return {p.rgba, p.rgba + std::size_t(4 * p.width * p.height)};
    }
    bool black() const {
        const auto rgba = pixels();
        for (std::size_t i = 0; i < rgba.size(); ++i)
            if (rgba[i] != (i % 4 == 3 ? 255 : 0)) return false;
        return true;
    }
    double psnr(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) const {
        double squares = 1e-9;
        for (std::size_t i = 0; i < a.size(); ++i)
            squares += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
        return 10.0 * std::log10(255.0 * 255.0 * double(a.size()) / squares);
    }

    patient::Package package = test::makeTrunk(0.003);
    patient::Patient patient{package};
    AcousticTable table = loadAcoustics(test::assetsFolder() / "ultrasound" / "tissues.toml");
    std::optional<Gpu> gpu;
    std::optional<DeformedPatient> deformed;
    std::optional<Ultrasound> machine;
    UltrasoundSettings settings;
    Transducer probe;
};

// Every line has contact, with breathing and a needle. The only remaining difference is that of float and
// half precision.
TEST_F(UltrasoundTest, MatchesTheReferencePicture) {
    settings.gel_m = 0.0;
    probe.half_angle_rad = 0.2;
    breathe(0.7);
    UltrasoundInput input = atTheFlank(0.012);
    const Pose in_picture{glm::angleAxis(1.2, Vec3(0, 1, 0)), Vec3(0.004, 0.001, 0.050)};
    input.patient_from_needle = *input.patient_from_probe * in_picture;
    input.depots = {
        {referenceFromTables(deformed->tables(), *input.patient_from_probe * Vec3(-0.008, 0.002, 0.030)),
         0.009},
        {referenceFromTables(deformed->tables(), *input.patient_from_probe * Vec3(0.006, 0.0, 0.045)),
         0.006}};
    const auto undeform = [&](const Vec3& p) { return referenceFromTables(deformed->tables(), p); };
    settings.place_samples = 1;
    const auto expected = test::referencePicture(
        test::referenceScan(test::encode(patient, table), table, undeform, input, settings, probe), settings,
        probe);
    for (const ScanPath path : {ScanPath::serial, ScanPath::prefix_sums}) {
        settings.path = path;
        const UltrasoundStats stats = machine->image(input, settings, probe);
        ASSERT_EQ(stats.reason, "");
        ASSERT_EQ(stats.contact, 1.0);
        const auto rgba = pixels();
        double squares = 0.0, count = 0.0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            if (int(i) % settings.width > settings.width - 16) continue;  // the ruler
            squares += std::pow(double(rgba[4 * i]) / 255.0 - expected[i], 2.0);
            ++count;
        }
        EXPECT_GT(-10.0 * std::log10(squares / count), 40.0) << int(path);
    }
}

TEST_F(UltrasoundTest, SerialAndPrefixSumPathsAgree) {
    breathe(0.5);
    settings.path = ScanPath::serial;
    machine->image(atTheFlank(), settings, probe);
    const auto serial = pixels();
    settings.path = ScanPath::prefix_sums;
    machine->image(atTheFlank(), settings, probe);
    EXPECT_GT(psnr(serial, pixels()), 45.0);
}

TEST_F(UltrasoundTest, StillPatientSkipDoesNotChangeThePicture) {
    breathe(0.6);
    machine->image(atTheFlank(), settings, probe);
    breathe(0.0);
    const UltrasoundStats with = machine->image(atTheFlank(), settings, probe);
    const auto a = pixels();
    deformed->breathe(package.motion.reference, false);
    const UltrasoundStats without = machine->image(atTheFlank(), settings, probe);
    EXPECT_GT(psnr(a, pixels()), 60.0);
    EXPECT_EQ(with.still_pictures, 1u);
    EXPECT_EQ(with.look_ups, 0u);
    EXPECT_EQ(without.still_pictures, 0u);
    EXPECT_GT(without.look_ups, 1000u);
}

TEST_F(UltrasoundTest, LinesInAirAreSkippedAndShowReverberation) {
    const UltrasoundStats with = machine->image(atTheFlank(0.002), settings, probe);
    const auto a = pixels();
    EXPECT_GT(with.contact, 0.1);
    EXPECT_LT(with.contact, 0.9);
    EXPECT_GT(with.skipped_lines, 5u);
    const auto e = machine->envelope();
    double near = 0.0, far = 0.0;  // of the first line
    for (int j = 0; j < settings.samples; ++j)
        (j < settings.samples / 8 ? near : far) =
            std::max(j < settings.samples / 8 ? near : far, double(e[std::size_t(j)]));
    EXPECT_GT(near, 0.01);
    EXPECT_LT(far, 1e-3);
    settings.skips.lines_in_air = false;
    const UltrasoundStats without = machine->image(atTheFlank(0.002), settings, probe);
    EXPECT_EQ(without.skipped_lines, 0u);
    EXPECT_GT(without.samples, with.samples);
}

TEST_F(UltrasoundTest, PressingHarderIncreasesContact) {
    double before = 0.0;
    for (const double press : {0.001, 0.004, 0.012}) {
        const double contact = machine->image(atTheFlank(press), settings, probe).contact;
        EXPECT_GT(contact, before);
        before = contact;
    }
    EXPECT_GT(before, 0.95);
}

TEST_F(UltrasoundTest, InvalidScansAreBlackWithAReason) {
    const auto reason = [&](const UltrasoundInput& input, const UltrasoundSettings& s) {
        const UltrasoundStats stats = machine->image(input, s, probe);
        EXPECT_TRUE(black());
        EXPECT_EQ(stats.samples, 0u);
        EXPECT_TRUE(machine->envelope().empty());
        return std::string(stats.reason);
    };
    EXPECT_EQ(reason({}, settings), "there is no probe");
    EXPECT_EQ(reason(atTheFlank(-0.05), settings), "the probe does not touch the skin");
    UltrasoundInput bone = atTheFlank();
    bone.patient_from_probe->position_m = Vec3(0.0, -0.058, 0.0);
    EXPECT_EQ(reason(bone, settings), "the probe is inside bone");
    UltrasoundInput far = atTheFlank();
    far.patient_from_probe->position_m = Vec3(1e300, 0, 0);
    EXPECT_EQ(reason(far, settings), "the probe's pose is not a pose");
    UltrasoundInput nan = atTheFlank();
    nan.patient_from_probe->position_m.y = kNaN;
    EXPECT_EQ(reason(nan, settings), "the probe's pose is not a pose");
    nan = atTheFlank();
    nan.patient_from_probe->rotation = {0, 0, 0, 0};
    EXPECT_EQ(reason(nan, settings), "the probe's pose is not a pose");
    nan = atTheFlank();
    nan.patient_from_needle = Pose{{kNaN, 0, 0, 0}, {}};
    EXPECT_EQ(reason(nan, settings), "the needle's pose is not a pose");
    nan = atTheFlank();
    nan.guide_m = std::array{Vec3(kNaN), Vec3(0.0)};
    EXPECT_EQ(reason(nan, settings), "the guide is not a line");
    const auto with = [&](auto&& change) {
        UltrasoundSettings s = settings;
        change(s);
        return reason(atTheFlank(), s);
    };
    EXPECT_EQ(with([](auto& s) { s.depth_m = kNaN; }), "the depth is not within 5 to 500 mm");
    EXPECT_EQ(with([](auto& s) { s.depth_m = -0.1; }), "the depth is not within 5 to 500 mm");
    EXPECT_EQ(with([](auto& s) { s.depth_m = 1e-6; }), "the depth is not within 5 to 500 mm");
    probe.depth_m = 0.0;
    EXPECT_EQ(reason(atTheFlank(), settings), "the depth is not within 5 to 500 mm");
    probe.depth_m = 0.160;
    EXPECT_EQ(with([](auto& s) { s.frequency_hz = kNaN; }), "frequency or focus is out of range");
    EXPECT_EQ(with([](auto& s) { s.gain_db = kNaN; }), "a gain is out of range");
    EXPECT_EQ(with([](auto& s) { s.tgc_db[7] = 1e9; }), "a gain is out of range");
    EXPECT_EQ(with([](auto& s) { s.gel_m = HUGE_VAL; }), "gel or noise is out of range");
    EXPECT_EQ(with([](auto& s) { s.noise_db = kNaN; }), "gel or noise is out of range");
    EXPECT_EQ(with([](auto& s) { s.dynamic_range_db = 0.0; }), "the dynamic range is out of range");
    EXPECT_EQ(with([](auto& s) { s.lines = 0; }), "lines, samples or planes are out of range");
    EXPECT_EQ(with([](auto& s) { s.samples = 1 << 30; }), "lines, samples or planes are out of range");
    EXPECT_EQ(with([](auto& s) { s.planes = -3; }), "lines, samples or planes are out of range");
    EXPECT_EQ(with([](auto& s) { s.width = 0; }), "the picture's size is out of range");
    EXPECT_EQ(with([](auto& s) { s.height = 1 << 30; }), "the picture's size is out of range");
    // Valid input works again.
    EXPECT_EQ(machine->image(atTheFlank(), settings, probe).reason, "");
    EXPECT_FALSE(black());
}

TEST_F(UltrasoundTest, FrozenPictureAcceptsNewGains) {
    machine->image(atTheFlank(), settings, probe);
    const auto scanned = pixels();
    settings.freeze = true;
    UltrasoundStats stats = machine->image({}, settings, probe);
    EXPECT_EQ(stats.reason, "");
    EXPECT_EQ(stats.frozen_pictures, 1u);
    EXPECT_EQ(stats.samples, 0u);
    EXPECT_EQ(pixels(), scanned);
    settings.gain_db = 12.0;
    machine->image({}, settings, probe);
    const auto brighter = pixels();
    double sum = 0.0;
    for (std::size_t i = 0; i < scanned.size(); i += 4)
        sum += double(brighter[i]) - scanned[i];
    EXPECT_GT(sum, 1000.0);
    settings.freeze = false;
    EXPECT_EQ(machine->image({}, settings, probe).reason, "there is no probe");
    // Without an earlier scan there is no picture to freeze.
    settings.freeze = true;
    EXPECT_EQ(machine->image({}, settings, probe).reason, "there is no probe");
}

TEST_F(UltrasoundTest, SlidersAmplifyTheirDepth) {
    machine->image(atTheFlank(), settings, probe);
    const auto flat = pixels();
    settings.tgc_db[5] = 15.0;
    machine->image(atTheFlank(), settings, probe);
    const auto bent = pixels();
    // Depth gains of the middle column: unchanged near the face and at the bottom, higher at 5/7 of the
    // depth.
    const ScanPlan plan = makeScanPlan(probe, settings);
    const auto gain_db = [&](std::size_t i) { return 20.0 * std::log10(plan.depths[i].gain) + kWhite_db; };
    EXPECT_NEAR(gain_db(0), 0.0, 1e-9);
    EXPECT_NEAR(gain_db(384 * 5 / 7), 15.0, 0.2);
    EXPECT_NEAR(gain_db(384 * 4 / 7), 0.0, 0.2);
    EXPECT_NE(flat, bent);
}

// Speckle is fixed to the tissue. A patient that moves under the probe shows the same grain at another
// place.
TEST_F(UltrasoundTest, SpeckleMovesWithTheTissue) {
    settings.samples = 512;
    const auto grain = [&](double dx) {
        UltrasoundInput input = atTheFlank(0.012);
        input.patient_from_probe->position_m.x -= dx;
        machine->image(input, settings, probe);
        return std::vector<float>(machine->envelope().begin(), machine->envelope().end());
    };
    const int shift = 6;  // bins
    const ScanPlan plan = makeScanPlan(probe, settings);
    const auto a = grain(0.0), b = grain(shift * plan.bin_m * 1550.0 / 1540.0);
    const auto correlation = [&](int moved) {
        const std::size_t middle = std::size_t(settings.lines / 2), n = std::size_t(settings.samples);
        double count = 0.0, sx = 0.0, sy = 0.0, sxy = 0.0, sxx = 0.0, syy = 0.0;
        for (std::size_t l = middle - 6; l < middle + 6; ++l)
            for (std::size_t j = 160; j < 260; ++j) {
                const double x = double(a[l * n + j + std::size_t(moved)]), y = double(b[l * n + j]);
                ++count, sx += x, sy += y, sxy += x * y, sxx += x * x, syy += y * y;
            }
        return (count * sxy - sx * sy) / std::sqrt((count * sxx - sx * sx) * (count * syy - sy * sy));
    };
    EXPECT_GT(correlation(shift), 0.85);
    EXPECT_LT(correlation(0), 0.4);
}

TEST_F(UltrasoundTest, ElectronicNoiseDiffersFromPictureToPicture) {
    settings.noise_db = -100.0;
    UltrasoundInput input = atTheFlank();
    machine->image(input, settings, probe);
    const auto first = pixels();
    machine->image(input, settings, probe);
    EXPECT_EQ(first, pixels());
    input.number = 1;
    machine->image(input, settings, probe);
    EXPECT_NE(first, pixels());
}

// Dashes beside the guide's line, on both sides. The line itself stays free for the needle.
TEST_F(UltrasoundTest, AGuideIsDrawnDashedBesideItsLine) {
    UltrasoundInput input = atTheFlank();
    const PictureView view = pictureView(probe, settings, 0.160);
    const Vec3 begin(0.02, 0, 0.01), end(-0.02, 0, 0.09), along = glm::normalize(end - begin);
    int left = 0, right = 0, on_line = 0;
    const auto count = [&] {
        left = right = on_line = 0;
        const auto rgba = pixels();
        for (std::size_t i = 0; i < rgba.size(); i += 4) {
            const int x = int(i / 4) % settings.width, y = int(i / 4) / settings.width;
            if (x >= settings.width - 16 || rgba[i] <= 120 || rgba[i + 2] + 60 >= rgba[i]) continue;
            const Vec3 p(view.left_m + (x + 0.5) * view.pixel_m, 0.0, view.top_m + (y + 0.5) * view.pixel_m);
            const double aside_m = (p.x - begin.x) * along.z - (p.z - begin.z) * along.x;
            (std::fabs(aside_m) < 0.002 ? on_line : aside_m < 0.0 ? left : right) += 1;
        }
    };
    machine->image(input, settings, probe);
    count();
    EXPECT_EQ(left + right + on_line, 0);
    input.guide_m = std::array{*input.patient_from_probe * begin, *input.patient_from_probe * end};
    machine->image(input, settings, probe);
    count();
    const double length_pixels = glm::distance(begin, end) / view.pixel_m;
    for (const int beside : {left, right}) {
        EXPECT_GT(beside, 0.2 * length_pixels);
        EXPECT_LT(beside, 0.9 * length_pixels);
    }
    EXPECT_EQ(on_line, 0);
}

TEST_F(UltrasoundTest, EveryCentimetreOfTheRulerCanBeSeen) {
    machine->image(atTheFlank(), settings, probe);
    const PictureView view = pictureView(probe, settings, 0.160);
    const auto rgba = pixels();
    for (int cm = 0; cm <= 16; ++cm) {
        int brightest = 0;
        const int row = int((0.01 * cm - view.top_m) / view.pixel_m);
        for (int y = std::max(row - 1, 0); y <= std::min(row + 1, settings.height - 1); ++y)
            brightest = std::max<int>(brightest, rgba[4 * std::size_t((y + 1) * settings.width - 4)]);
        EXPECT_GT(brightest, 100) << cm;
    }
}

class DopplerTest : public UltrasoundTest {
  protected:
    // Blood flow along the probe's +z, in a block of the liver at 50 mm.
    void flowAt(double speed_m_per_s) {
        patient::VesselFlow flow;
        flow.grid.dims = Index3(40);
        flow.grid.spacing_m = Vec3(0.0005);
        flow.grid.origin_m = *atTheFlank().patient_from_probe * Vec3(0.0, 0.0, 0.050) - Vec3(0.010);
        flow.scale_m_per_s = 2.0;
        const Vec3 v =
            atTheFlank().patient_from_probe->direction({0, 0, speed_m_per_s}) / flow.scale_m_per_s * 32767.0;
        flow.velocity.assign(
            flow.grid.voxelCount(),
            {std::int16_t(std::lround(v.x)), std::int16_t(std::lround(v.y)), std::int16_t(std::lround(v.z)),
             std::int16_t(patient::kBloodKindStep * int(patient::BloodKind::other))});
        machine->setFlow(&flow);
        settings.doppler = DopplerBox{.from_share = 0.3, .to_share = 0.7, .from_m = 0.03, .to_m = 0.07};
        UltrasoundInput input = atTheFlank();
        factor = patient::pulse(patient::BloodKind::other, input.time_s);
        settings.doppler->nyquist_m_per_s = 0.3 * factor;
        machine->image(input, settings, probe);
    }
    struct Colours {
        int red = 0, blue = 0;
    };
    Colours colours() const {
        Colours c;
        const auto rgba = pixels();
        for (std::size_t i = 0; i < rgba.size(); i += 4) {
            c.red += rgba[i] > rgba[i + 2] + 60 &&
                     int((i / 4) % std::size_t(settings.width)) < settings.width - 16;
            c.blue += rgba[i + 2] > rgba[i] + 60;
        }
        return c;
    }
    double factor = 1.0;
};

// HZ-TEACH-04
TEST_F(DopplerTest, TowardTheProbeIsRedAwayIsBlue) {
    flowAt(-0.2);
    EXPECT_GT(colours().red, 150);
    EXPECT_EQ(colours().blue, 0);
    flowAt(0.2);
    EXPECT_EQ(colours().red, 0);
    EXPECT_GT(colours().blue, 150);
}

TEST_F(DopplerTest, FlowAboveNyquistIsAliased) {
    flowAt(-0.4);
    EXPECT_EQ(colours().red, 0);
    EXPECT_GT(colours().blue, 150);
}

TEST_F(DopplerTest, WallFilterRemovesSlowFlow) {
    flowAt(-0.005);
    EXPECT_EQ(colours().red + colours().blue, 0);
    settings.doppler->wall_filter_m_per_s = 0.0;
    machine->image(atTheFlank(), settings, probe);
    EXPECT_GT(colours().red, 50);
}

TEST_F(DopplerTest, TheBoxHasAnUnbrokenOutline) {
    flowAt(0.2);
    const PictureView view = pictureView(probe, settings, 0.160);
    const auto rgba = pixels();
    for (double depth_m = settings.doppler->from_m; depth_m < settings.doppler->to_m; depth_m += 0.001) {
        const ScanLine line = scanLine(probe, 2.0 * settings.doppler->from_share - 1.0);
        const Vec3 p = line.origin_m + depth_m * line.direction;
        int yellow = 0;
        for (int dx = -1; dx <= 1; ++dx) {
            const std::size_t x = std::size_t((p.x - view.left_m) / view.pixel_m + dx),
                              y = std::size_t((p.z - view.top_m) / view.pixel_m),
                              at = 4 * (y * std::size_t(settings.width) + x);
            yellow = std::max(yellow, int(rgba[at + 1]) - int(rgba[at + 2]));
        }
        EXPECT_GT(yellow, 30) << depth_m;
    }
}

TEST_F(DopplerTest, NoFlowGivesNoColour) {
    machine->setFlow(nullptr);
    settings.doppler = DopplerBox{};
    machine->image(atTheFlank(), settings, probe);
    EXPECT_EQ(colours().red + colours().blue, 0);
}

}  // namespace
}  // namespace stylet::render
