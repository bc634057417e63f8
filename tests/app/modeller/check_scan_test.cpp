// Unusual scans and typical defects of a segmentation are found, with their cause and a cure.
#include "app/modeller/check/check_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "patient/synth/labels.h"
#include "tests/app/modeller/lung_phantom.h"
#include "tests/app/modeller/reference_patient.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

const Package& reference() {
    static const Package package = test::stillPatient(1, 0.003);
    return package;
}

Package copy() {
    return reference();
}

ScanMeasures measure(const Package& p) {
    return measureScan(PackageStatistics(p));
}

// The finding about `what`, formatted, or an empty string.
std::string finding(const Package& p, const std::string& what) {
    Findings findings;
    checkScan(PackageStatistics(p), findings);
    const auto found = std::find_if(findings.list.begin(), findings.list.end(),
                                    [&](const Finding& f) { return f.what == what; });
    return found == findings.list.end() ? "" : formatFinding(*found);
}

// The same patient with voxels of half the size.
Package refined(const Package& p) {
    Package fine = p;
    const auto refine = [](const auto& coarse, auto& volume) {
        Grid g = coarse.grid;
        g.dims *= 2, g.spacing_m *= 0.5, g.origin_m -= 0.5 * g.spacing_m;
        volume = std::remove_cvref_t<decltype(volume)>(g);
        forEachVoxel(g, [&](const Index3& i) { volume[i] = coarse[i / 2]; });
    };
    refine(p.ct, fine.ct);
    refine(p.labels, fine.labels);
    return fine;
}

void setHu(Package& p, Id id, int hu) {
    for (std::size_t i = 0; i < p.ct.voxels.size(); ++i)
        if (p.labels.voxels[i] == std::uint8_t(id)) p.ct.voxels[i] = std::int16_t(hu);
}

void relabel(Package& p, Id from, Id to) {
    std::replace(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(from), std::uint8_t(to));
}

TEST(ScanMeasures, OfTheReferencePatient) {
    const ScanMeasures s = measure(reference());
    EXPECT_NEAR(s.liver_hu, 112.0, 3.0);
    EXPECT_NEAR(s.vessels_hu, 159.0, 4.0);
    EXPECT_NEAR(s.aorta_hu, 170.0, 4.0);
    EXPECT_NEAR(s.noise_hu, 11.0, 2.5);
    EXPECT_LT(s.fat_in_ducts, 0.07);  // 0.05 at 3 mm, where thin ducts have voxels of fat
    EXPECT_EQ(s.fascia_outside, 0.0);
    Findings findings;
    checkScan(PackageStatistics(reference()), findings);
    EXPECT_TRUE(findings.list.empty()) << formatFinding(findings.list.front());
}

// The difference of two uniform values in [-w, w] is below 0.586 w with probability one half.
TEST(ScanMeasures, NoiseOfUniformValuesInClosedForm) {
    Package p = copy();
    std::uint64_t state = 1;
    constexpr int kHalf = 60;
    for (std::size_t i = 0; i < p.ct.voxels.size(); ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        if (p.labels.voxels[i] == std::uint8_t(Id::liver))
            p.ct.voxels[i] = std::int16_t(100 + int((state >> 33) % (2 * kHalf + 1)) - kHalf);
    }
    EXPECT_NEAR(measure(p).noise_hu, 0.5858 * kHalf / (0.6745 * 1.4142), 1.0);
}

TEST(CheckScan, NamesThePhase) {
    using testing::HasSubstr, testing::StartsWith;
    const std::string what = "vessels brighter than the liver";
    const std::string native = finding(test::stillPatient(1, 0.003, {"native"}), what);
    EXPECT_THAT(native, StartsWith("REFUSED"));
    EXPECT_THAT(native, HasSubstr("without contrast medium"));
    EXPECT_THAT(native, HasSubstr("portal venous phase"));
    const std::string arterial = finding(test::stillPatient(1, 0.003, {"arterial"}), what);
    EXPECT_THAT(arterial, StartsWith("REFUSED"));
    EXPECT_THAT(arterial, HasSubstr("an arterial phase"));
    EXPECT_THAT(finding(test::stillPatient(1, 0.003, {"late"}), what), HasSubstr("a late phase"));
    EXPECT_EQ(finding(test::stillPatient(1, 0.003, {"80-kv"}), what), "");
}

// A build of a scan without contrast medium finds no aorta, and takes noise for vessels. Of an arterial
// phase, it finds the aorta.
TEST(CheckScan, NoiseTakenForVesselsDoesNotHideThePhase) {
    // Keeps one vessel voxel of `step`, and makes it bright.
    const auto scanned = [](int step) {
        Package p = test::stillPatient(1, 0.003, {"native"});
        const double liver_hu = measure(p).liver_hu;
        int n = 0;
        for (std::uint8_t& id : p.labels.voxels)
            if ((id == std::uint8_t(Id::portal) || id == std::uint8_t(Id::hepaticVeins)) && n++ % step != 0)
                id = std::uint8_t(Id::liver);
        setHu(p, Id::portal, int(liver_hu) + 60);
        setHu(p, Id::hepaticVeins, int(liver_hu) + 60);
        return p;
    };
    for (const auto& [step, share] : {std::pair{3, 0.010}, {20, 0.0016}}) {
        Package native = scanned(step);
        EXPECT_NEAR(measure(native).vessel_share, share, 0.1 * share);
        relabel(native, Id::aorta, Id::visceralFat);
        const std::string verdict = finding(native, "vessels in the liver");
        EXPECT_THAT(verdict, testing::StartsWith("REFUSED")) << step;
        EXPECT_THAT(verdict, testing::HasSubstr("without contrast medium")) << step;
    }
    Package arterial = scanned(20);
    setHu(arterial, Id::aorta, 300);
    EXPECT_THAT(finding(arterial, "vessels in the liver"), testing::HasSubstr("an arterial phase"));
}

TEST(CheckScan, AWrongDistanceOfTheSlicesIsNamed) {
    const std::string what = "distance of ribs above one another";
    for (const double factor : {0.5, 2.0}) {
        Package lie = copy();
        for (Grid* g : {&lie.ct.grid, &lie.labels.grid})
            g->spacing_m.z *= factor, g->origin_m.z *= factor;
        EXPECT_THAT(finding(lie, what), testing::StartsWith(factor < 1.0 ? "REFUSED" : "look"));
        EXPECT_THAT(finding(lie, what), testing::HasSubstr("wrong distance of its slices")) << factor;
    }
    const Package child = test::stillPatient(1, 0.003, {"child"});
    EXPECT_EQ(finding(child, what), "");
    EXPECT_NEAR(measure(reference()).rib_distance_median, 0.11, 0.007);
    EXPECT_NEAR(measure(child).rib_distance_median, measure(reference()).rib_distance_median, 0.01);
    // The bones of arms do not widen the chest, not even a broken one.
    Package arms = copy();
    const int last = arms.labels.grid.dims.x - 1, low = arms.labels.grid.dims.z / 3;
    forEachVoxel(arms.labels.grid, [&](const Index3& i) {
        const bool broken = i.x == 0 && (i.z == low || i.z == 2 * low) && i.y == 30;
        if ((std::min(i.x, last - i.x) < 3 && i.y != 30) || broken) arms.labels[i] = std::uint8_t(Id::spine);
    });
    EXPECT_NEAR(measure(arms).rib_distance_median, measure(reference()).rib_distance_median, 0.002);
    // If ribs are missing, the lower quartile stays the same.
    Package missing = copy();
    const double middle_m = missing.labels.grid.centre(missing.labels.grid.dims / 2).z;
    forEachVoxel(missing.labels.grid, [&](const Index3& i) {
        const bool rib = missing.labels[i] == std::uint8_t(Id::ribsLeft);
        if (rib && std::fabs(missing.labels.grid.centre(i).z - middle_m) < 0.012) missing.labels[i] = 0;
    });
    EXPECT_NEAR(measure(missing).rib_distance_quartile, measure(reference()).rib_distance_quartile, 0.005);
    // Imported bones may have no marrow.
    Package hollow = copy();
    const Mask bone = labelMask(hollow.labels, hollow.label_table, isBone);
    const FloatVolume depth_m = distanceTo(inverted(bone));
    for (std::size_t i = 0; i < depth_m.voxels.size(); ++i)
        if (depth_m.voxels[i] > 0.0035f) hollow.labels.voxels[i] = std::uint8_t(Id::muscle);
    EXPECT_EQ(finding(hollow, what), "");
    EXPECT_FALSE(std::isnan(measure(hollow).rib_distance_median));
}

TEST(CheckScan, MissingOrSmallVessels) {
    Package none = copy();
    relabel(none, Id::portal, Id::liver);
    relabel(none, Id::hepaticVeins, Id::liver);
    EXPECT_THAT(finding(none, "vessels in the liver"), testing::StartsWith("REFUSED"));
    // A trunk outside the liver is no vessel in it.
    Package trunk = none;
    relabel(trunk, Id::spleen, Id::portal);
    EXPECT_LT(measure(trunk).vessel_share, 0.001);
    EXPECT_THAT(finding(trunk, "vessels in the liver"), testing::StartsWith("REFUSED"));
    relabel(none, Id::ducts, Id::liver);  // without a target there is no path to rate
    EXPECT_THAT(finding(none, "vessels in the liver"), testing::StartsWith("look"));
    // Keep one vessel voxel of `step`. The others become tumour, so that no vessel gets more parenchyma
    // around it.
    const auto thinned = [](int step) {
        Package p = copy();
        int n = 0;
        for (std::uint8_t& id : p.labels.voxels)
            if ((id == std::uint8_t(Id::portal) || id == std::uint8_t(Id::hepaticVeins)) && n++ % step != 0)
                id = std::uint8_t(Id::tumour);
        return p;
    };
    const double share = measure(reference()).vessel_share;
    EXPECT_NEAR(measure(thinned(5)).vessel_share, share / 5.0, 0.01 * share);
    EXPECT_THAT(finding(thinned(int(share / 0.010)), "vessels in the liver"), testing::StartsWith("look"));
    EXPECT_THAT(finding(thinned(int(share / 0.003)), "vessels in the liver"), testing::StartsWith("REFUSED"));
}

TEST(CheckScan, NoiseIsReported) {
    const std::string noisy = finding(test::stillPatient(1, 0.003, {"noise-x3"}), "noise in the liver");
    EXPECT_THAT(noisy, testing::StartsWith("look"));
    EXPECT_THAT(noisy, testing::HasSubstr("soft kernel"));
}

TEST(CheckScan, ThickSlicesAreReportedThenRefused) {
    const auto scanned = [](double blur_voxels) {
        Package p = copy();
        p.ct = test::lungOnDiaphragm(blur_voxels, 10.0);
        p.labels = LabelVolume(p.ct.grid);
        return finding(p, "blur across slices");
    };
    EXPECT_EQ(scanned(1.6), "") << "slices of 3 mm";
    EXPECT_THAT(scanned(1.83), testing::StartsWith("look"));
    EXPECT_THAT(scanned(2.06), testing::StartsWith("REFUSED")) << "slices of 5 mm";
    EXPECT_THAT(scanned(2.06), testing::HasSubstr("thinner slices"));
}

// In voxels of 3 mm, too little of the lungs' base shows.
TEST(CheckScan, DistantSlicesAreRefusedWhereTheirBlurDoesNotShow) {
    Package p = copy();
    ASSERT_TRUE(std::isnan(measure(p).blur_across_m));
    const auto scanned = [&p](double slice_mm) {
        p.scan.slice_m = 1e-3 * slice_mm;
        return finding(p, "distance of slices");
    };
    EXPECT_EQ(scanned(0.0), "") << "unknown";
    EXPECT_EQ(scanned(4.0 + 1e-6), "") << "rounded";
    EXPECT_THAT(scanned(5.0), testing::StartsWith("REFUSED  distance of slices: 5 mm"));
    p.ct = test::lungOnDiaphragm(0.7, 10.0);
    p.labels = LabelVolume(p.ct.grid);
    EXPECT_EQ(scanned(5.0), "") << "the scan is sharper than its header says";
}

TEST(CheckScan, SoftKernelIsReported) {
    Package coarse = copy(), fine = copy();
    fine.ct = test::lungOnDiaphragm(0.7, 10.0);  // voxels of 1 mm
    fine.labels = LabelVolume(fine.ct.grid);
    const auto scanned = [](Package& p, double blur_mm) {
        p.scan.blur_within_m = 1e-3 * blur_mm;
        return finding(p, "blur within slices");
    };
    EXPECT_EQ(scanned(fine, 0.8), "");
    EXPECT_THAT(scanned(fine, 1.12), testing::StartsWith("look     blur within slices: 1.12 mm"));
    EXPECT_EQ(scanned(coarse, 2.9), "") << "wide voxels blur too";
    EXPECT_NE(scanned(coarse, 3.1), "");
}

TEST(CheckScan, MissingOrgansAreReported) {
    for (const auto& [id, name] : {std::pair{Id::kidneyRight, "right kidney"},
                                   {Id::kidneyLeft, "left kidney"},
                                   {Id::spleen, "spleen"}}) {
        Package p = copy();
        relabel(p, id, Id::visceralFat);
        EXPECT_THAT(finding(p, name), testing::HasSubstr("0 ml")) << name;
        for (const char* other : {"right kidney", "left kidney", "spleen"})
            EXPECT_EQ(finding(p, other).empty(), std::string(other) != name) << other;
    }
}

TEST(CheckScan, CutFlankIsRefusedAlsoWithAirAdded) {
    const ScanMeasures whole = measure(reference());
    EXPECT_LT(whole.flat_right, 0.2);
    EXPECT_LT(whole.flat_left, 0.2);
    Package p = copy();
    const Grid& g = p.ct.grid;
    int right = 0;
    forEachVoxel(g, [&](const Index3& i) { right = p.labels[i] != 0 ? std::max(right, i.x) : right; });
    // As a build does: air replaces what the scan does not show.
    forEachVoxel(g, [&](const Index3& i) {
        if (i.x > right - 8) p.ct[i] = -1024, p.labels[i] = 0;
    });
    EXPECT_GT(measure(p).flat_right, 0.4);
    for (const Package& cut : {p, refined(p)}) {
        EXPECT_THAT(finding(cut, "right flank in one plane"), testing::StartsWith("REFUSED"));
        EXPECT_EQ(finding(cut, "left flank in one plane"), "");
    }
}

// An ellipse 342 mm wide has the same flanks at any voxel size.
TEST(ScanMeasures, FlatShareOfAnEllipseInClosedForm) {
    constexpr double kHalfWidth_m = 0.1709, kHalfDepth_m = 0.110;
    for (const double spacing_m : {0.001, 0.003}) {
        Package p = test::makeSlabs({{Tissue::soft, 0.01}}, 0.005);
        const Vec3 low_m{-0.18, -0.12, 0.0};
        p.ct = CtVolume(Grid{Index3(int(0.36 / spacing_m), int(0.24 / spacing_m), 3), Vec3(spacing_m), low_m},
                        std::int16_t(-1000));
        p.labels = LabelVolume(p.ct.grid);
        forEachVoxel(p.ct.grid, [&](const Index3& i) {
            const Vec3 at = p.ct.grid.centre(i) / Vec3(kHalfWidth_m, kHalfDepth_m, 1.0);
            if (at.x * at.x + at.y * at.y < 1.0) p.ct[i] = 40;
        });
        // Rows that end within 3 mm of the outermost one.
        const double share = std::sqrt(1.0 - std::pow(1.0 - 0.003 / kHalfWidth_m, 2.0));
        EXPECT_NEAR(measure(p).flat_right, share, 0.03) << spacing_m;
        EXPECT_NEAR(measure(p).flat_left, share, 0.03) << spacing_m;
    }
}

// A cube of bone, 2 * reach + 1 voxels wide, where the liver with its vessels first surrounds it.
Package withStone(int reach, Index3* centre = nullptr) {
    Package p = copy();
    const Grid& g = p.labels.grid;
    constexpr auto kWhole = patient::synth::anyOf({Id::liver, Id::portal, Id::hepaticVeins, Id::ducts});
    bool placed = false;
    forEachVoxel(g, [&](const Index3& i) {
        if (placed || p.labels[i] != std::uint8_t(Id::liver)) return;
        bool inside = true;
        forEachVoxel(boxAround(g, i, reach + 1), [&](const Index3& n) {
            inside = inside && patient::synth::contains(kWhole, p.labels[n]);
        });
        if (!inside) return;
        placed = true;
        if (centre) *centre = i;
        forEachVoxel(boxAround(g, i, reach + 1),
                     [&](const Index3& n) { p.labels[n] = std::uint8_t(Id::liver); });
        forEachVoxel(boxAround(g, i, reach),
                     [&](const Index3& n) { p.labels[n] = std::uint8_t(Id::ribsRight); });
    });
    return p;
}

TEST(CheckScan, BoneAtTheLiverIsReported) {
    EXPECT_EQ(measure(reference()).bone_at_liver_mm2, 0.0);
    // Cubes of 9 and 15 mm.
    EXPECT_NEAR(measure(withStone(1)).bone_at_liver_mm2, 6 * 81.0, 1e-6);
    EXPECT_THAT(finding(withStone(1), "bone at the liver"), testing::StartsWith("look"));
    EXPECT_THAT(finding(withStone(2), "bone at the liver"), testing::StartsWith("REFUSED"));
    const Package fine = refined(withStone(2));
    EXPECT_NEAR(measure(fine).bone_at_liver_mm2, 6 * 225.0, 1e-6);
    EXPECT_THAT(finding(fine, "bone at the liver"), testing::StartsWith("REFUSED"));
    EXPECT_THAT(finding(refined(withStone(1)), "bone at the liver"), testing::StartsWith("look"));
}

// A piece of bone inside the liver is reported unless it is connected to a rib.
TEST(CheckScan, BoneInsideTheLiverIsReported) {
    using testing::HasSubstr, testing::StartsWith;
    const std::string what = "bone inside the liver";
    EXPECT_EQ(measure(reference()).bone_in_liver_mm3, 0.0);
    Index3 centre{0};
    Package stone = withStone(1, &centre);
    EXPECT_NEAR(measure(stone).bone_in_liver_mm3, 729.0, 1e-6);  // 9 mm cubed
    EXPECT_NEAR(measure(refined(stone)).bone_in_liver_mm3, 729.0, 1e-6);
    EXPECT_THAT(finding(stone, what), StartsWith("look"));
    EXPECT_THAT(finding(stone, what), HasSubstr("a calcified tumour"));
    EXPECT_THAT(finding(stone, what), HasSubstr("Correct the stage bones"));
    EXPECT_EQ(finding(withStone(0), what), "");  // 27 mm^3
    // The same stone in the CT alone, under the label of the liver.
    Package dense = stone;
    forEachVoxel(boxAround(dense.ct.grid, centre, 1),
                 [&](const Index3& n) { dense.labels[n] = std::uint8_t(Id::liver), dense.ct[n] = 700; });
    EXPECT_NEAR(measure(dense).bone_in_liver_mm3, 729.0, 1e-6);
    // A bridge to the nearest rib.
    const Grid& g = reference().labels.grid;
    Index3 rib{0};
    double nearest = 1e9;
    forEachVoxel(g, [&](const Index3& i) {
        const double distance = glm::length(Vec3(i - centre));
        if (reference().labels[i] == std::uint8_t(Id::ribsRight) && distance < nearest)
            nearest = distance, rib = i;
    });
    const int steps = 2 * int(std::ceil(nearest));
    for (int k = 0; k <= steps; ++k)
        stone.labels[Index3(glm::round(glm::mix(Vec3(centre), Vec3(rib), double(k) / steps)))] =
            std::uint8_t(Id::ribsRight);
    EXPECT_EQ(measure(stone).bone_in_liver_mm3, 0.0);
}

TEST(CheckScan, CalcifiedTumourIsReported) {
    EXPECT_THAT(finding(test::stillPatient(1, 0.002, {"calcified-tumour"}), "bone inside the liver"),
                testing::StartsWith("look"));
}

TEST(CheckScan, OrgansTakenForCartilageAreReported) {
    const std::string what = "cartilage";
    EXPECT_EQ(finding(reference(), what), "");
    Package p = copy();
    relabel(p, Id::spleen, Id::cartilage);
    EXPECT_THAT(finding(p, what), testing::StartsWith("look"));
    relabel(p, Id::liver, Id::cartilage);
    EXPECT_THAT(finding(p, what), testing::StartsWith("REFUSED"));
    for (const Id bone : {Id::spine, Id::ribsRight, Id::ribsLeft, Id::sternum})
        relabel(p, bone, Id::cartilage);
    EXPECT_EQ(finding(p, what), "");  // nothing to compare with
    EXPECT_EQ(finding(test::stillPatient(1, 0.003, {"child"}), what), "");
}

TEST(CheckScan, DuctsInFatAreReported) {
    Package p = copy();
    setHu(p, Id::ducts, -60);
    EXPECT_THAT(finding(p, "ducts in fat"), testing::StartsWith("REFUSED"));
    p = copy();
    // A fifth of the ducts, at one end.
    std::vector<std::size_t> ducts;
    for (std::size_t i = 0; i < p.labels.voxels.size(); ++i)
        if (p.labels.voxels[i] == std::uint8_t(Id::ducts)) ducts.push_back(i);
    for (std::size_t i = 0; i < ducts.size() / 5; ++i)
        p.ct.voxels[ducts[i]] = -100;
    EXPECT_THAT(finding(p, "ducts in fat"), testing::StartsWith("look"));
}

TEST(CheckScan, FasciaOutsideTheBodyIsRefused) {
    Package p = copy();
    // A second fascia in the air in front of the body, as large as a tenth of the true one.
    const Grid& g = p.labels.grid;
    const double fascia =
        double(std::count(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::fascia)));
    double added = 0.0;
    forEachVoxel(g, [&](const Index3& i) {
        if (i.y == g.dims.y - 2 && p.labels[i] == 0 && added < 0.1 * fascia)
            p.labels[i] = std::uint8_t(Id::fascia), ++added;
    });
    EXPECT_NEAR(measure(p).fascia_outside, 0.1 / 1.1, 0.005);
    EXPECT_THAT(finding(p, "fascia outside the body"), testing::StartsWith("REFUSED"));
}

}  // namespace
}  // namespace stylet::modeller
