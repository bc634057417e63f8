#include "render/ultrasound/transducer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patient/package/package.h"
#include "tests/render/pictures.h"
#include "tests/render/refusal.h"

namespace stylet::render {
namespace {

constexpr char kGoodTransducer[] =
    "name = \"p\"\nshape = \"convex\"\nradius_mm = 60\nhalf_angle_deg = 30\ndepth_mm = 160\nfrequency_mhz = "
    "3.5\n"
    "lowest_frequency_mhz = 2\nhighest_frequency_mhz = 5\nfocus_mm = 80\naperture_mm = 24\npulse_cycles = "
    "2.5\n"
    "thickness_mm = 2.4\nthickness_focus_mm = 75\nthickness_range_mm = 50\n";

Transducer parseTransducerText(const std::string& text) {
    return parseTransducer("probe.toml", text);
}

TEST(Transducers, ShippedTransducersMatchTheModel) {
    const auto folder = test::assetsFolder() / "ultrasound";
    const Transducer convex = loadTransducer(folder / "convex.toml");
    // The default values equal those in the file.
    const Transducer plain;
    EXPECT_EQ(convex.name, plain.name);
    EXPECT_NEAR(convex.half_angle_rad, plain.half_angle_rad, 1e-6);
    EXPECT_NEAR(convex.radius_m, plain.radius_m, 1e-9);
    EXPECT_NEAR(convex.aperture_m, plain.aperture_m, 1e-9);
    EXPECT_NEAR(convex.thickness_m, plain.thickness_m, 1e-9);
    EXPECT_EQ(convex.frequency_hz, 3.5e6);
    EXPECT_NEAR(convex.depth_m, 0.160, 1e-9);
    const Transducer linear = loadTransducer(folder / "linear.toml");
    EXPECT_EQ(linear.shape, TransducerShape::linear);
    for (double depth = 0.0; depth <= convex.depth_m; depth += 0.01) {  // model, section 7: 2 to 5 mm
        EXPECT_GE(beamThickness_m(convex, depth), 0.002);
        EXPECT_LE(beamThickness_m(convex, depth), 0.005);
    }
}

TEST(Transducers, LinesFanOutFromTheFace) {
    const Transducer convex;
    const ScanLine middle = scanLine(convex, 0.0), edge = scanLine(convex, 1.0);
    EXPECT_EQ(middle.origin_m, Vec3(0.0));
    EXPECT_EQ(middle.direction, Vec3(0, 0, 1));
    EXPECT_NEAR(edge.direction.x, 0.5, 1e-6);
    EXPECT_NEAR(edge.origin_m.x, 0.030, 1e-6);
    EXPECT_NEAR(edge.origin_m.z, -0.060 * (1.0 - std::sqrt(0.75)), 1e-6);
    EXPECT_NEAR(linePitch_m(convex, 256, 0.160), 0.220 * M_PI / 3.0 / 255.0, 1e-6);
    Transducer linear;
    linear.shape = TransducerShape::linear;
    EXPECT_NEAR(scanLine(linear, -1.0).origin_m.x, -0.020, 1e-12);
    EXPECT_EQ(scanLine(linear, 1.0).direction, Vec3(0, 0, 1));
}

TEST(Transducers, TakeTheScanLinesOfAFace) {
    const auto folder = test::assetsFolder() / "ultrasound";
    const Transducer convex = loadTransducer(folder / "convex.toml"),
                     linear = loadTransducer(folder / "linear.toml");
    const Transducer bent = withFace(linear, 0.030, 0.020);
    EXPECT_EQ(bent.shape, TransducerShape::convex);
    EXPECT_NEAR(scanLine(bent, 1.0).origin_m.x, 0.015, 1e-12);
    EXPECT_NEAR(scanLine(bent, -1.0).direction.x, -0.75, 1e-12);
    EXPECT_EQ(bent.frequency_hz, linear.frequency_hz);
    const Transducer flat = withFace(convex, 0.050, 10.0);
    EXPECT_EQ(flat.shape, TransducerShape::linear);
    EXPECT_EQ(scanLine(flat, 1.0).origin_m.x, 0.025);
    EXPECT_EQ(flat.aperture_m, convex.aperture_m);
    EXPECT_NEAR(withFace(convex, 0.5, 0.06).half_angle_rad, M_PI / 2.0, 1e-12) << "at most a half circle";
}

TEST(Transducers, BeamIsNarrowestAtTheFocusAndAtHigherFrequency) {
    const Transducer probe;
    const double at_focus = beamWidth_m(probe, 3.5e6, 0.080, 0.080);
    EXPECT_LT(at_focus, beamWidth_m(probe, 3.5e6, 0.040, 0.080));
    EXPECT_LT(at_focus, beamWidth_m(probe, 3.5e6, 0.140, 0.080));
    EXPECT_LT(beamWidth_m(probe, 5e6, 0.080, 0.080), at_focus);
    EXPECT_NEAR(at_focus, 1.2 * 1540.0 / 3.5e6 * 0.080 / 0.024 / std::sqrt(2.0), 1e-9);
    EXPECT_NEAR(pulseLength_m(probe, 3.5e6), 0.00055, 1e-9);
}

TEST(Transducers, RejectsInvalidTransducers) {
    const auto with = [](const char* from, const char* to) {
        return test::replaced(kGoodTransducer, from, to);
    };
    EXPECT_NO_THROW(parseTransducerText(kGoodTransducer));
    test::expectRefusals(
        parseTransducerText,
        {{with("radius_mm = 60", "radius_mm = 0"), "probe.toml: radius_mm: 0 is not in [5, 200]"},
         {with("\"convex\"", "\"round\""), "neither convex nor linear"},
         {with("\"convex\"", "\"linear\""), "width_mm"},
         {with("frequency_mhz = 3.5", "frequency_mhz = 9"), "frequency_mhz"},
         {with("highest_frequency_mhz = 5", "highest_frequency_mhz = 1"), "below"},
         {with("depth_mm = 160", "depth_mm = inf"), "depth_mm"},
         {with("pulse_cycles = 2.5", "pulse_cycles = []"), "pulse_cycles"},
         {with("name = \"p\"", "name = 3"), "name"},
         {"", "name"},
         {"[", "line 1"}});
}

}  // namespace
}  // namespace stylet::render
