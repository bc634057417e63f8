// Closed-form tests of the naive reference and of both GPU algorithms for scan lines.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/render/pictures.h"
#include "tests/render/ultrasound/sound_phantoms.h"

namespace stylet::render {
namespace {

using test::Scan;
using test::ScanMethod;

class Physics : public testing::TestWithParam<ScanMethod> {
  protected:
    void SetUp() override {
        if (GetParam() == ScanMethod::reference) return;
        if (const auto why = test::noGpuReason(); !why.empty()) GTEST_SKIP() << why;
    }
    Scan scan(const patient::Package& package, const AcousticTable& table, const UltrasoundInput& input,
              const UltrasoundSettings& settings, const Transducer& probe) {
        return test::scan(GetParam(), package, table, input, settings, probe);
    }
};

// Tests that only run on the GPU, because the reference would need a minute.
class PhysicsOnGpu : public Physics {};
INSTANTIATE_TEST_SUITE_P(By, PhysicsOnGpu, testing::Values(ScanMethod::serial, ScanMethod::prefix_sums),
                         [](const auto& of) { return test::scanMethodName(of.param); });

INSTANTIATE_TEST_SUITE_P(By, Physics,
                         testing::Values(ScanMethod::reference, ScanMethod::serial, ScanMethod::prefix_sums),
                         [](const auto& of) { return test::scanMethodName(of.param); });

UltrasoundSettings few(int samples) {
    UltrasoundSettings s;
    s.lines = 12;
    s.samples = samples;
    s.planes = 1;
    s.compensation_db_per_cm_mhz = 0.0;
    return s;
}

struct Peak {
    double value = 0.0, at_m = 0.0;
};
// Peak of the middle line: its height, and as its position the centroid of the values above half of it.
Peak findPeak(const Scan& s, double from_m) {
    Peak peak;
    const int line = s.lines / 2;
    for (int j = int(from_m / s.bin_m); j < s.bins; ++j)
        peak.value = std::max(peak.value, s.at(line, j));
    double sum = 0.0, moment = 0.0;
    for (int j = int(from_m / s.bin_m); j < s.bins; ++j) {
        const double above = std::max(s.at(line, j) - 0.5 * peak.value, 0.0);
        sum += above;
        moment += above * j * s.bin_m;
    }
    peak.at_m = moment / sum;
    return peak;
}

// The echo is tanh(jump) = (Z2 - Z1)/(Z2 + Z1), for any sampling and any position of the border.
TEST_P(Physics, InterfacesReflectTheirContrastAtAnySampling) {
    const AcousticTable table = test::mirrorTable();
    const struct {
        const char *from, *to;
        double db;
    } borders[] = {{"fat", "muscle", -19.7}, {"liver", "bile", -25.3}, {"liver", "bone", -3.7}};
    for (const auto& border : borders) {
        const patient::Package package =
            test::soundLayers({{border.from, 0.020}, {border.to, 0.050}}, 0.070, 0.001);
        for (const int samples : {160, 256, 512, 1024})
            for (const double z_m : {0.0020, 0.00213, 0.0031}) {
                const Scan s = scan(package, table, test::probeAt(z_m), few(samples), test::flatProbe());
                EXPECT_NEAR(20.0 * std::log10(findPeak(s, 0.004).value), border.db, 0.5)
                    << border.from << " to " << border.to << ", " << samples << " samples, face at " << z_m;
            }
    }
}

TEST_P(Physics, PlanesAppearAtTheTimeOfFlightDepth) {
    const AcousticTable table = test::mirrorTable();
    const patient::Package package =
        test::soundLayers({{"fat", 0.020}, {"muscle", 0.016}, {"bile", 0.030}}, 0.070, 0.001);
    for (const int samples : {256, 512})
        for (const double z_m : {0.0020, 0.00237, 0.0031}) {
            const Scan s = scan(package, table, test::probeAt(z_m), few(samples), test::flatProbe());
            const double fat = 1540.0 * (0.020 - z_m) / 1450.0, both = fat + 1540.0 * 0.016 / 1580.0;
            EXPECT_NEAR(findPeak(s, 0.030).at_m, both, 0.0001) << samples;
            // The first border, without the second.
            Scan first = s;
            for (int j = int(0.030 / s.bin_m); j < s.bins; ++j)
                first.envelope[std::size_t(s.lines / 2) * std::size_t(s.bins) + std::size_t(j)] = 0.0;
            EXPECT_NEAR(findPeak(first, 0.004).at_m, fat, 0.0001) << samples;
        }
}

// Metres of fluid on the middle line, from one depth to another.
double fluidOnLine_m(const UltrasoundInput& input, double from_m, double to_m) {
    const double step_m = 0.0001;
    double sum_m = 0.0;
    for (double z_m = from_m; z_m < to_m; z_m += step_m)
        sum_m += step_m * test::fluidShare(input.depots, Vec3(0.0, 0.0, z_m));
    return sum_m;
}

// Tissue that soaked up fluid is dark, but not black, without a bright border; the tissue behind it gets the
// sound that the fluid did not attenuate.
TEST_P(PhysicsOnGpu, ADepotIsDarkAndEnhancesWhatLiesBehind) {
    AcousticTable table = test::soundTable();
    table.roughness = 0.0;
    const patient::Package package = test::soundLayers({{"liver", 0.070}}, 0.070, 0.001);
    UltrasoundInput input = test::probeAt(0.002);
    UltrasoundSettings s = few(512);
    s.lines = 96, s.planes = 3;
    const Scan without = scan(package, table, input, s, test::flatProbe());
    input.depots = {{Vec3(0.0, 0.0, 0.027), 0.008}};
    const Scan with = scan(package, table, input, s, test::flatProbe());
    const auto change_db = [&](double from_m, double to_m) {
        return 20.0 * std::log10(with.rms(0.46, 0.54, from_m, to_m) / without.rms(0.46, 0.54, from_m, to_m));
    };
    EXPECT_NEAR(change_db(0.004, 0.009), 0.0, 0.1) << "in front of it";
    EXPECT_LT(change_db(0.024, 0.030), -9.0);
    EXPECT_GT(change_db(0.024, 0.030), -20.0);
    const auto liver = std::ranges::find(table.acoustics, "liver", &Acoustic::name);
    ASSERT_NE(liver, table.acoustics.end());
    const auto spared_db = [&](double to_m) {
        return 2.0 * fluidOnLine_m(input, 0.0, to_m) * 3.5 * liver->attenuation_db_per_m_mhz;
    };
    for (double z_m = 0.010; z_m < 0.044; z_m += 0.001)
        EXPECT_LT(change_db(z_m, z_m + 0.002), spared_db(z_m + 0.002) + 3.0) << "a bright border, " << z_m;
    EXPECT_NEAR(change_db(0.046, 0.056), spared_db(0.046), 0.8);
    EXPECT_NEAR(20.0 * std::log10(with.rms(0.0, 0.08, 0.019, 0.031) / without.rms(0.0, 0.08, 0.019, 0.031)),
                0.0, 0.1)
        << "beside it";
}

// Soft tissue soaks up injected fluid, but the rib that it surrounds does not.
TEST_P(Physics, ARibInADepotKeepsItsEchoAndItsShadow) {
    AcousticTable table = test::soundTable();
    table.roughness = 0.0;
    const double rib_m = 0.014, bone_m = 0.003;
    const patient::Package package =
        test::soundLayers({{"muscle", rib_m}, {"bone", bone_m}, {"liver", 0.053}}, 0.070, 0.001);
    UltrasoundInput input = test::probeAt(0.002);
    const UltrasoundSettings s = few(512);
    const Scan without = scan(package, table, input, s, test::flatProbe());
    input.depots = {{Vec3(0.0, 0.0, rib_m), 0.006}};
    const Scan with = scan(package, table, input, s, test::flatProbe());

    const auto tissue = [&](const char* name) -> const Acoustic& {
        return *std::ranges::find(table.acoustics, name, &Acoustic::name);
    };
    const Acoustic &muscle = tissue("muscle"), &fluid = tissue("gel"), &bone = tissue("bone"),
                   &liver = tissue("liver");
    // A tissue with the same impedance as the soaked one at this depth.
    const auto soaked = [&](Acoustic dry, double z_m) {
        const double share = test::fluidShare(input.depots, Vec3(0.0, 0.0, z_m));
        dry.impedance_rayl =
            std::exp(std::lerp(std::log(dry.impedance_rayl), std::log(fluid.impedance_rayl), share));
        return dry;
    };
    const auto passes = [](const Acoustic& from, const Acoustic& to) {
        return 1.0 - reflectivity(from, to) * reflectivity(from, to);
    };
    const auto db = [](double ratio) { return 20.0 * std::log10(ratio); };
    const auto spared_db = [&](const Acoustic& dry, double from_m, double to_m) {
        return 2.0 * fluidOnLine_m(input, from_m, to_m) * 3.5 *
               (dry.attenuation_db_per_m_mhz - fluid.attenuation_db_per_m_mhz);
    };
    const double in_front_db = spared_db(muscle, 0.0, rib_m), in_front_m = fluidOnLine_m(input, 0.0, rib_m);
    const Acoustic before = soaked(muscle, rib_m), behind = soaked(liver, rib_m + bone_m);
    const Peak rib = findPeak(without, 0.005), rib_in_depot = findPeak(with, 0.005);
    EXPECT_NEAR(db(rib_in_depot.value / rib.value),
                in_front_db + db(reflectivity(before, bone) / reflectivity(muscle, bone)), 1.0);
    const double slower_m = in_front_m * 1540.0 * (1.0 / fluid.speed_m_per_s - 1.0 / muscle.speed_m_per_s);
    EXPECT_NEAR(rib_in_depot.at_m, rib.at_m + slower_m, 0.0003);
    // In the shadow, behind the fluid. The rib's own attenuation stays.
    const double spared_behind_db = spared_db(liver, rib_m + bone_m, 0.030);
    EXPECT_NEAR(
        db(with.rms(0.38, 0.62, 0.030, 0.040) / without.rms(0.38, 0.62, 0.030, 0.040)),
        in_front_db + spared_behind_db +
            db(passes(before, bone) * passes(bone, behind) / (passes(muscle, bone) * passes(bone, liver))),
        2.0);
}

// As much fluid is shown as was injected.
TEST(Fluid, HasTheVolumeOfItsBall) {
    const double radius_m = 0.008, step_m = 0.0005, reach_m = 0.020;
    const std::vector<UltrasoundInput::Depot> depots{{Vec3(0.1, -0.05, 0.2), radius_m}};
    double volume_m3 = 0.0;
    for (double x = -reach_m; x <= reach_m; x += step_m)
        for (double y = -reach_m; y <= reach_m; y += step_m)
            for (double z = -reach_m; z <= reach_m; z += step_m)
                volume_m3 += step_m * step_m * step_m *
                             test::fluidShare(depots, depots[0].centre_reference_m + Vec3(x, y, z));
    EXPECT_NEAR(volume_m3 / (4.0 / 3.0 * M_PI * std::pow(radius_m, 3.0)), 1.0, 0.15);
}

// An oblique border reflects less, by the factor (d . n).
TEST_P(Physics, ASlantedBorderIsFainter) {
    const AcousticTable table = test::mirrorTable();
    const double slope = std::tan(M_PI / 6);
    const patient::Package package =
        test::soundBlock(Vec3(0.030, 0.012, 0.0), 0.070, 0.001,
                         [&](const Vec3& p) { return p.z < 0.030 + slope * p.x ? "fat" : "muscle"; });
    Transducer narrow = test::flatProbe();
    narrow.aperture_m = 0.190;  // such a narrow beam meets the border at one depth
    UltrasoundSettings s = few(512);
    s.lines = 200;
    const Scan slanted = scan(package, table, test::probeAt(0.002), s, narrow);
    double sum = 0.0;
    for (int l = 60; l < 140; ++l) {
        double peak = 0.0;
        for (int j = 40; j < slanted.bins; ++j)
            peak = std::max(peak, slanted.at(l, j));
        sum += peak / 80.0;
    }
    const double expected = (1.70 - 1.38) / (1.70 + 1.38) * std::cos(M_PI / 6);
    EXPECT_LT(sum, 1.1 * expected);
    EXPECT_GT(sum, 0.6 * expected);  // the beam's width spreads the rest
}

// Checks Rayleigh's ratio of mean to standard deviation, and the strength given in the table.
TEST_P(Physics, SpeckleIsRayleighDistributed) {
    AcousticTable table = test::soundTable();
    for (Acoustic& a : table.acoustics)
        a.attenuation_db_per_m_mhz = 0.0;
    const patient::Package package =
        test::soundBlock(Vec3(0.125, 0.012, 0.0), 0.170, 0.004, [](const Vec3&) { return "liver"; });
    UltrasoundSettings s = few(512);
    s.lines = 192;
    s.planes = 3;
    const Transducer convex;
    const Scan grain = scan(package, table, test::probeAt(0.010), s, convex);
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (int l = 20; l < s.lines - 20; ++l)
        for (int j = 60; j < 460; ++j) {
            sum += grain.at(l, j);
            squares += grain.at(l, j) * grain.at(l, j);
            ++count;
        }
    const double mean = sum / count, deviation = std::sqrt(squares / count - mean * mean);
    EXPECT_NEAR(mean / deviation, 1.91, 0.05);
    for (const double from : {0.02, 0.06, 0.10, 0.13})
        EXPECT_NEAR(20.0 * std::log10(grain.rms(0.1, 0.9, from, from + 0.025)), -45.0, 0.8) << from;
}

// Speckle does not depend on the sampling.
TEST_P(PhysicsOnGpu, SpeckleStrengthIsIndependentOfSampling) {
    AcousticTable table = test::soundTable();
    for (Acoustic& a : table.acoustics)
        a.attenuation_db_per_m_mhz = 0.0;
    const patient::Package package =
        test::soundBlock(Vec3(0.125, 0.012, 0.0), 0.170, 0.004, [](const Vec3&) { return "liver"; });
    for (const auto& [lines, samples, planes] : {std::array{128, 256, 1}, std::array{256, 512, 3},
                                                 std::array{256, 1024, 5}, std::array{256, 1900, 3}}) {
        UltrasoundSettings s = few(samples);
        s.lines = lines;
        s.planes = planes;
        const Scan grain = scan(package, table, test::probeAt(0.010), s, Transducer{});
        EXPECT_NEAR(20.0 * std::log10(grain.rms(0.1, 0.9, 0.02, 0.15)), -45.0, 0.8) << lines;
    }
}

TEST_P(Physics, SlabEchoDecaysWithAttenuation) {
    const AcousticTable table = test::soundTable();
    const patient::Package package =
        test::soundBlock(Vec3(0.125, 0.012, 0.0), 0.170, 0.004, [](const Vec3&) { return "liver"; });
    UltrasoundSettings s = few(512);
    s.lines = 192;
    s.planes = 3;
    s.compensation_db_per_cm_mhz = 0.55;
    const Scan slab = scan(package, table, test::probeAt(0.010), s, Transducer{});
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (double from = 0.015; from < 0.145; from += 0.005) {
        const double x = from + 0.0025, y = 20.0 * std::log10(slab.rms(0.1, 0.9, from, from + 0.005));
        ++n, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double slope_db_per_m = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    // Per drawn metre, both ways. The machine compensates 55 dB/(m MHz).
    const double lost = 2.0 * 3.5 * 70.0 * 1550.0 / 1540.0, given = 2.0 * 3.5 * 55.0;
    EXPECT_NEAR(slope_db_per_m - given, -lost, 0.02 * lost);
}

// 8 mm of rib at 3.5 MHz: attenuation and two borders, both ways.
TEST_P(Physics, RibCastsAShadow) {
    AcousticTable table = test::soundTable();
    for (Acoustic& a : table.acoustics)
        if (a.name == "liver") a.attenuation_db_per_m_mhz = 0.0;
    const patient::Package package = test::soundBlock(
        Vec3(0.030, 0.012, 0.0), 0.090, 0.001,
        [](const Vec3& p) { return p.x < 0.0 && p.z >= 0.020 && p.z < 0.028 ? "bone" : "liver"; });
    UltrasoundSettings s = few(512);
    s.lines = 128;
    const Scan rib = scan(package, table, test::probeAt(0.002), s, test::flatProbe());
    const double shadow =
        20.0 * std::log10(rib.rms(0.05, 0.35, 0.030, 0.056) / rib.rms(0.65, 0.95, 0.030, 0.056));
    const double r = (7.8 - 1.65) / (7.8 + 1.65);
    const double expected = -2.0 * 5.0 * 3.5 * 0.8 + 2.0 * 20.0 * std::log10(1.0 - r * r);
    EXPECT_NEAR(expected, -37.6, 0.1);  // the model: about 37 dB
    EXPECT_NEAR(shadow, expected, 1.0);
}

TEST_P(Physics, GasHidesWhatIsBehindIt) {
    const AcousticTable table = test::soundTable();
    const patient::Package package = test::soundBlock(
        Vec3(0.030, 0.012, 0.0), 0.090, 0.001,
        [](const Vec3& p) { return p.x < 0.0 && p.z >= 0.020 && p.z < 0.028 ? "gas" : "liver"; });
    UltrasoundSettings s = few(512);
    s.lines = 128;
    const Scan gas = scan(package, table, test::probeAt(0.002), s, test::flatProbe());
    EXPECT_LT(gas.rms(0.05, 0.35, 0.040, 0.056) / gas.rms(0.65, 0.95, 0.040, 0.056), 1e-3);
}

// Ducts are dark. Tissue behind them is brighter, because they attenuate less. A lesion is as dark as its
// scatter.
TEST_P(Physics, DuctsAndLesionsAreDistinguishable) {
    AcousticTable table = test::soundTable();
    const auto block = [&](const char* what) {
        return test::soundBlock(Vec3(0.030, 0.012, 0.0), 0.090, 0.001, [what](const Vec3& p) {
            return std::hypot(p.x, p.z - 0.028) < 0.008 ? what : "liver";
        });
    };
    UltrasoundSettings s = few(512);
    s.lines = 160;
    s.planes = 3;
    s.compensation_db_per_cm_mhz = 0.70;
    const auto db = [](double ratio) { return 20.0 * std::log10(ratio); };
    const Scan duct = scan(block("bile"), table, test::probeAt(0.002), s, test::flatProbe());
    const double beside = duct.rms(0.05, 0.20, 0.018, 0.034);
    EXPECT_LT(db(duct.rms(0.46, 0.54, 0.023, 0.029) / beside), -25.0);
    const double enhanced = db(duct.rms(0.45, 0.55, 0.040, 0.056) / duct.rms(0.05, 0.20, 0.040, 0.056));
    EXPECT_NEAR(enhanced, 2.0 * 3.5 * 1.6 * 0.70, 2.0);
    for (Acoustic& a : table.acoustics)
        if (a.name == "tumour") a.impedance_rayl = 1.65e6;
    const Scan lesion = scan(block("tumour"), table, test::probeAt(0.002), s, test::flatProbe());
    EXPECT_NEAR(db(lesion.rms(0.42, 0.58, 0.021, 0.031) / lesion.rms(0.05, 0.20, 0.021, 0.031)), -6.5, 1.5);
}

TEST_P(Physics, NeedleIsVisibleOnlyWithinTheBeam) {
    const AcousticTable table = test::soundTable();
    const patient::Package package =
        test::soundBlock(Vec3(0.030, 0.012, 0.0), 0.070, 0.002, [](const Vec3&) { return "liver"; });
    UltrasoundSettings s = few(512);
    s.lines = 96;
    s.planes = 3;
    s.compensation_db_per_cm_mhz = 0.70;
    const auto with = [&](double elevation_m, double tilt) {
        UltrasoundInput input = test::probeAt(0.002);
        const Vec3 axis(std::cos(tilt), 0.0, -std::sin(tilt)), y(0, 1, 0);
        input.patient_from_needle =
            Pose{glm::quat_cast(glm::dmat3(y, glm::cross(axis, y), axis)), Vec3(0.0, elevation_m, 0.032)};
        return scan(package, table, input, s, test::flatProbe());
    };
    const Scan without = scan(package, table, test::probeAt(0.002), s, test::flatProbe());
    const auto above_db = [&](const Scan& scan_of) {
        return 20.0 * std::log10(scan_of.rms(0.6, 0.9, 0.029, 0.031) / without.rms(0.6, 0.9, 0.029, 0.031));
    };
    const Scan in_plane = with(0.0, 0.0);
    EXPECT_GT(above_db(in_plane), 20.0);
    EXPECT_NEAR(above_db(with(0.010, 0.0)), 0.0, 0.1);
    EXPECT_LT(above_db(with(0.002, 0.0)), above_db(in_plane) - 3.0);
    // Tests the needle's shadow. There must be none in front of the needle or beyond its tip.
    const auto ratio = [&](double from, double to, double from_m, double to_m) {
        return in_plane.rms(from, to, from_m, to_m) / without.rms(from, to, from_m, to_m);
    };
    EXPECT_LT(ratio(0.6, 0.9, 0.052, 0.058), 0.7);
    EXPECT_NEAR(ratio(0.6, 0.9, 0.010, 0.025), 1.0, 0.02);
    EXPECT_NEAR(ratio(0.1, 0.4, 0.020, 0.050), 1.0, 0.05);
}

// The face is flat but the pressed skin is not. Gaps in between count as gel, not air.
TEST_P(PhysicsOnGpu, UnevenSkinUnderTheFaceHidesNoLine) {
    const patient::Package package =
        test::soundBlock(Vec3(0.030, 0.012, 0.0), 0.070, 0.001, [](const Vec3& p) {
            return p.z < 0.001 + 0.0008 * std::sin(700.0 * p.x + 500.0 * p.y) ? "air" : "liver";
        });
    UltrasoundSettings s = few(512);
    s.lines = 96;
    s.planes = 3;
    s.compensation_db_per_cm_mhz = 0.70;
    const Scan scanned = scan(package, test::soundTable(), test::probeAt(0.0), s, test::flatProbe());
    const double all = scanned.rms(0.0, 1.0, 0.010, 0.040);
    for (int line = 0; line < s.lines; line += 4) {
        const double from = double(line) / s.lines, to = double(line + 4) / s.lines;
        EXPECT_GT(scanned.rms(from, to, 0.010, 0.040), 0.6 * all) << "line " << line;
    }
}

}  // namespace
}  // namespace stylet::render
