#include "app/modeller/segmentation/bones.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "app/modeller/segmentation/bone_voxels.h"
#include "app/modeller/wall/bright_rim.h"
#include "app/modeller/wall/costal_cartilage.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// Muscle with an upright bone shaft and a kidney. The shaft is 14 mm wide, lies in front, and contains
// marrow as dark as fat.
CtVolume shaftAndKidney() {
    CtVolume ct({Index3(80, 80, 40), Vec3(0.001), Vec3(0.0)}, 55);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const double r = std::hypot(i.x - 60, i.y - 65);
        if (r < 7.0) ct[i] = r < 4.5 ? -40 : 700;
        if (std::hypot(i.x - 20, i.y - 30, i.z - 20) < 12.0) ct[i] = 240;
    });
    return ct;
}

TEST(Bones, CortexIsFilledAndKidneyIsExcluded) {
    const CtVolume ct = shaftAndKidney();
    const Bones b = findBones(ct, Mask(ct.grid, 1), {});
    EXPECT_FALSE((b.all[{20, 30, 20}]));
    EXPECT_TRUE((b.all[{60, 71, 20}]));
    EXPECT_TRUE((b.all[{60, 65, 20}]));
    EXPECT_NEAR(volume_ml(b.all), 3.14159 * 49.0 * 40.0 * 1e-3, 0.5);
}

// At 80 kV, with the kidney in the back and in the middle of the body's depth, with a darker medulla, and
// joined to the bone by a vein. The adversary is bone as dense as the kidney and as large, with a cortex.
TEST(Bones, ADenseKidneyIsExcluded) {
    for (const auto& [depth, medulla_hu, vein] :
         {std::tuple(30, 318, false), {42, 318, false}, {42, 212, false}, {42, 212, true}}) {
        CtVolume ct({Index3(110, 80, 40), Vec3(0.001), Vec3(0.0)}, 55);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const double noise_hu = 25.0 * test::noiseAt(ct.grid.offset(i)), y = i.y - depth, z = i.z - 20;
            if (const double r = std::hypot(i.x - 20, y, z); r < 14.5)
                ct[i] = std::int16_t((r < 10.0 ? medulla_hu : 318) + noise_hu);
            if (const double r = std::hypot(i.x - 88, y, z); r < 14.5)
                ct[i] = std::int16_t((r < 13.0 ? 318 : 600) + noise_hu);
            else if (vein && std::hypot(y, z) < 4.0 && i.x > 20 && i.x < 88 && ct[i] < 200)
                ct[i] = 245;
        });
        const Bones b = findBones(ct, Mask(ct.grid, 1), {});
        EXPECT_FALSE((b.all[{20, depth, 20}]));
        EXPECT_TRUE((b.all[{88, depth, 20}]));
        EXPECT_NEAR(volume_ml(b.all), 4.0 / 3.0 * 3.14159 * std::pow(1.45, 3), 0.5);
    }
}

// A vessel at 80 kV beside a vertebra. Only the kidneys tell that so dense a vessel may occur.
TEST(Bones, WithDenseKidneysADenseVesselIsNoBone) {
    const auto shareOfVessel = [](int kidneys_hu) {
        CtVolume ct({Index3(180, 90, 40), Vec3(0.001), Vec3(0.0)}, 55);
        const auto inVessel = [](const Index3& i) { return std::hypot(i.x - 115, i.y - 36) < 9.0; };
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const double noise_hu = 28.0 * test::noiseAt(ct.grid.offset(i));
            if (std::hypot(std::abs(i.x - 90) - 60, i.y - 30, i.z - 20) < 14.5)
                ct[i] = std::int16_t(kidneys_hu + noise_hu);
            if (inVessel(i)) ct[i] = std::int16_t(285 + noise_hu);
            if (const double r = std::hypot(i.x - 90, i.y - 30); r < 17.0)
                ct[i] = std::int16_t((r < 14.0 ? 240 : 900) + noise_hu);
        });
        const Bones b = findBones(ct, Mask(ct.grid, 1), {});
        EXPECT_TRUE((b.all[{90, 46, 20}]));
        double bone = 0.0, all = 0.0;
        forEachVoxel(ct.grid, [&](const Index3& i) {
            if (inVessel(i)) bone += b.all[i], all += 1.0;
        });
        return bone / all;
    };
    EXPECT_LT(shareOfVessel(325), 0.1);
    EXPECT_GT(shareOfVessel(190), 0.5);
}

// The same values in the middle of the body are a vertebra's in wide voxels, also beside an arm. So dense a
// piece in the front third is no kidney either.
TEST(Bones, ABoneLikeAKidneyIsKeptElsewhere) {
    for (const auto& [x, y, arm] : {std::tuple(55, 30, false), {55, 30, true}, {20, 62, false}}) {
        CtVolume ct({Index3(arm ? 180 : 110, 80, 40), Vec3(0.001), Vec3(0.0)}, 55);
        Mask body(ct.grid);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const double noise_hu = 25.0 * test::noiseAt(ct.grid.offset(i));
            body[i] = i.x < 110 || (i.y > 30 && i.y < 50);
            if (const double r = std::hypot(i.x - x, i.y - y, i.z - 20); r < 14.5)
                ct[i] = std::int16_t((r < 11.0 ? 225 : 330) + noise_hu);
        });
        EXPECT_TRUE((findBones(ct, body, {}).all[{x, y, 20}])) << x << ' ' << y << ' ' << arm;
    }
}

// A shaft 14 mm wide with a cortex of 1.5 mm around marrow, blurred by [1 2 1]/4 per axis: the muscle beside
// it is raised to 260 HU and more, above every bone threshold.
TEST(Bones, BlurredCortexHasNoRimOfBone) {
    FloatVolume hu({Index3(80, 80, 40), Vec3(0.001), Vec3(0.0)}, 55.0f);
    const auto radius = [](const Index3& i) { return std::hypot(i.x - 60, i.y - 65); };
    forEachVoxel(hu.grid, [&](const Index3& i) {
        if (radius(i) < 7.0) hu[i] = radius(i) < 5.5 ? 200.0f : 900.0f;
    });
    for (const int axis : {0, 1, 2})
        parallelLines(1, hu.grid.dims, axis, hu.voxels.data(), smoothLine);
    CtVolume ct(hu.grid);
    std::size_t raised = 0, rim = 0, missed = 0, shaft = 0;
    forEachVoxel(ct.grid, [&](const Index3& i) {
        ct[i] = std::int16_t(std::lround(hu[i]));
        raised += radius(i) >= 7.0 && ct[i] > 200;
    });
    ASSERT_GT(raised, 1000u);
    const Bones b = findBones(ct, Mask(ct.grid, 1), {});
    forEachVoxel(ct.grid, [&](const Index3& i) {
        rim += b.all[i] && radius(i) >= 7.0;
        shaft += radius(i) < 7.0;
        missed += !b.all[i] && radius(i) < 7.0;
    });
    EXPECT_EQ(rim, 0u);
    EXPECT_LT(double(missed), 0.05 * double(shaft));
}

constexpr double kRibHalfX = 6.1, kRibHalfY = 3.6;  // voxels; the grid's voxels are 1 mm

// A rib along z with an elliptic section. From slice to slice the section moves by a fraction of a voxel. The
// cortex is 1.5 mm thick and 800 HU, or `thin_hu` in five of every eight slices. The marrow is 230 HU. Muscle
// 3 mm thick surrounds the rib, and fat surrounds the muscle. A voxel is its centre's value, or with
// `averaged` the mean of 5 x 5 points. Then [1 2 1]/4 along each axis blurs the image, once or more often.
struct RibPhantom {
    CtVolume ct{{Index3(80, 80, 48), Vec3(0.001), Vec3(0.0)}, 0};
    explicit RibPhantom(bool averaged, float thin_hu = 800.0f, int blurs = 1) {
        FloatVolume hu(ct.grid);
        forEachVoxel(hu.grid, [&](const Index3& i) {
            float sum = 0.0f;
            for (int n = 0; n < 25; ++n) {
                const double step = averaged ? 0.2 : 0.0;
                const double x = i.x + step * (n % 5 - 2), y = i.y + step * (n / 5 - 2);
                const float cortex_hu = i.z % 8 < 3 ? 800.0f : thin_hu;
                sum += share(x, y, i.z, -1.5) < 1.0  ? 230.0f
                       : share(x, y, i.z, 0.0) < 1.0 ? cortex_hu
                       : share(x, y, i.z, 3.0) < 1.0 ? 58.0f
                                                     : -105.0f;
            }
            hu[i] = sum / 25.0f;
        });
        for (int n = 0; n < blurs; ++n)
            for (const int axis : {0, 1, 2})
                parallelLines(1, hu.grid.dims, axis, hu.voxels.data(), smoothLine);
        for (std::size_t i = 0; i < hu.voxels.size(); ++i)
            ct.voxels[i] = std::int16_t(std::lround(hu.voxels[i]));
    }
    // Below 1 in the rib's section, enlarged by `more` on each side.
    static double share(double x, double y, int z, double more) {
        return std::hypot((x - 60.0 - 0.13 * z) / (kRibHalfX + more),
                          (y - 62.0 + 0.21 * z) / (kRibHalfY + more));
    }
    // Mean distance by which the border of `found` lies outside the true border [mm].
    static double borderOffset(const Mask& found) {
        const double a = kRibHalfX, b = kRibHalfY, pi = 3.14159265;
        const double perimeter = pi * (3.0 * (a + b) - std::sqrt((3.0 * a + b) * (a + 3.0 * b)));
        return (double(countVoxels(found)) / found.grid.dims.z - pi * a * b) / perimeter;
    }
};

// The adversaries are a fixed threshold and half of the blurred maximum, both with the marrow filled in. A
// scan with wider blur than the rule undoes leaves part of the offset.
TEST(Bones, ARibsBorderIsUnbiased) {
    const RibPhantom rib(false), wider(true);
    const auto above = [](const CtVolume& ct, int threshold_hu) {
        Mask m = maskWhere(ct.grid, [&](std::size_t i) { return ct.voxels[i] > threshold_hu; });
        fillHolesPerSlice(m);
        return RibPhantom::borderOffset(m);
    };
    const auto half = [](const CtVolume& ct) {
        const int beside_hu = 0;  // mean of muscle and fat
        return (*std::max_element(ct.voxels.begin(), ct.voxels.end()) + beside_hu) / 2;
    };
    const auto found = [](const CtVolume& ct) {
        return RibPhantom::borderOffset(findBones(ct, Mask(ct.grid, 1), {}).all);
    };
    EXPECT_GT(above(rib.ct, 200), 0.5);
    EXPECT_GT(above(rib.ct, half(rib.ct)), 0.08);
    EXPECT_NEAR(found(rib.ct), 0.0, 0.05);
    EXPECT_GT(above(wider.ct, half(wider.ct)), 0.27);
    EXPECT_LT(std::fabs(found(wider.ct)), 0.25);
}

// The same rule with and without the blur of this scan (three times the variance of the usual one).
TEST(Bones, AMeasuredBlurGivesAThinnerRim) {
    const RibPhantom soft(false, 800.0f, 3);
    const Mask body(soft.ct.grid, 1);
    const double usual_mm = RibPhantom::borderOffset(findBones(soft.ct, body, {}).all),
                 measured_mm = RibPhantom::borderOffset(
                     findBones(soft.ct, body, {.within_m = 0.00122, .across_m = 0.00122}).all);
    std::printf("border of a rib in a soft scan: %+.2f mm, with its blur %+.2f mm\n", usual_mm, measured_mm);
    EXPECT_GT(usual_mm, 0.2);
    EXPECT_LT(std::fabs(measured_mm), 0.5 * usual_mm);
}

// The lowest rib's tip: 8 mm wide, a cortex of 1 mm. In a soft scan it is nowhere above 300 HU, but in the
// sharpened scan it is. The adversary is a vessel with contrast medium, almost as bright as the tip, that
// touches the thick part of the rib. Sharpening raises the noise almost sixfold, which must not turn the
// vessel into bone.
TEST(Bones, ARibsTipIsFoundInASoftScan) {
    FloatVolume hu({Index3(90, 50, 40), Vec3(0.001), Vec3(0.0)}, 55.0f);
    const auto along = [](const Index3& i, int y) { return std::hypot(i.y - y, i.z - 20); };
    forEachVoxel(hu.grid, [&](const Index3& i) {
        if (i.x > 25 && i.x < 80 && along(i, 30) < 4.5) hu[i] = 250.0f;
        if (i.x > 10 && i.x < 80 && along(i, 15) < 4.0) hu[i] = along(i, 15) < 3.0 ? 130.0f : 680.0f;
        if (i.x > 10 && i.x < 40)
            if (const double r = along(i, 19); r < 8.0) hu[i] = r < 6.0 ? 150.0f : 900.0f;
    });
    for (int n = 0; n < 3; ++n)
        for (const int axis : {0, 1, 2})
            parallelLines(1, hu.grid.dims, axis, hu.voxels.data(), smoothLine);
    const VoxelBox thin_part{{50, 0, 0}, {79, 49, 39}};
    for (const double noise_hu : {4.0, 15.0}) {
        CtVolume ct(hu.grid);
        for (std::size_t i = 0; i < ct.voxels.size(); ++i)
            ct.voxels[i] = std::int16_t(hu.voxels[i] + noise_hu * test::noiseAt(i));
        const Bones b = findBones(ct, Mask(ct.grid, 1), {.within_m = 0.00122, .across_m = 0.00122});
        double tip = 0.0, vessel = 0.0, found_tip = 0.0, found_vessel = 0.0;
        float brightest_hu = 0.0f;
        forEachVoxel(thin_part, [&](const Index3& i) {
            const bool in_tip = along(i, 15) < 4.0, in_vessel = along(i, 30) < 4.5;
            tip += in_tip, found_tip += in_tip && b.all[i];
            vessel += in_vessel, found_vessel += in_vessel && b.all[i];
            if (in_tip) brightest_hu = std::max(brightest_hu, hu[i]);
        });
        std::printf("noise %.0f HU, a rib's tip of at most %.0f HU: %.2f found; vessel: %.2f\n", noise_hu,
                    double(brightest_hu), found_tip / tip, found_vessel / vessel);
        EXPECT_LT(brightest_hu, 290.0f);
        if (noise_hu < 10.0) {
            EXPECT_GT(found_tip, 0.7 * tip);
        }
        EXPECT_LT(found_vessel, 0.02 * vessel) << noise_hu;
    }
}

// A rib that lies in thick slices: y and z are exchanged, and the scan is blurred again along z.
CtVolume ribInThickSlices(int blurs) {
    const RibPhantom upright(false);
    const Index3 dims = upright.ct.grid.dims;
    FloatVolume hu({{dims.x, dims.z, dims.y}, Vec3(0.001), Vec3(0.0)});
    forEachVoxel(hu.grid, [&](const Index3& i) { hu[i] = upright.ct[{i.x, i.z, i.y}]; });
    for (int n = 0; n < blurs; ++n)
        parallelLines(1, hu.grid.dims, 2, hu.voxels.data(), smoothLine);
    CtVolume ct(hu.grid);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        ct.voxels[i] = std::int16_t(std::lround(hu.voxels[i]));
    return ct;
}

TEST(Bones, ARibInThickSlicesHasAThinnerRimWithTheirBlur) {
    const CtVolume ct = ribInThickSlices(2);
    const auto offset = [&](const ScanBlur& blur) {
        const Mask found = findBones(ct, Mask(ct.grid, 1), blur).all;
        Mask upright({{found.grid.dims.x, found.grid.dims.z, found.grid.dims.y}, Vec3(0.001), Vec3(0.0)});
        forEachVoxel(found.grid, [&](const Index3& i) { upright[{i.x, i.z, i.y}] = found[i]; });
        return RibPhantom::borderOffset(upright);
    };
    const double usual_mm = offset({}), measured_mm = offset({.across_m = 0.00122});
    std::printf("border of a rib in thick slices: %+.2f mm, with their blur %+.2f mm\n", usual_mm,
                measured_mm);
    EXPECT_GT(usual_mm, 0.1);
    EXPECT_LT(std::fabs(measured_mm), 0.5 * usual_mm);
}

// Muscle that blur has raised above the bone threshold, and that is neither bone nor its rim, stops a needle.
TEST(Bones, TheRimReachesAsFarAsTheBlur) {
    constexpr double kAcross = 2.4, kBone_hu = 150.0;  // blur in voxels, as in slices of 5 mm
    CtVolume ct({Index3(40), Vec3(0.001), Vec3(0.0)}, 0);
    Mask bones(ct.grid);
    const auto above = [](double z) { return 0.5 * std::erfc(z / (kAcross * std::sqrt(2.0))); };
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const bool beside = i.x >= 10 && i.x < 30 && i.y >= 10 && i.y < 30;
        bones[i] = beside && i.z >= 10 && i.z < 30;
        ct[i] = std::int16_t(50.0 + (beside ? 950.0 * (above(9.5 - i.z) - above(29.5 - i.z)) : 0.0));
    });
    const Mask body(ct.grid, 1);
    const auto left = [&](const ScanBlur& blur) {
        const Mask known = unite(bones, brightRim(ct, body, bones, kBone_hu, blur));
        return countVoxels(
            maskWhere(ct.grid, [&](std::size_t i) { return !known.voxels[i] && ct.voxels[i] >= kBone_hu; }));
    };
    EXPECT_GT(left({}), 0u);
    EXPECT_EQ(left({.across_m = 0.001 * kAcross}), 0u);
}

// A piece of bone that the rule for cortex missed stays bone: bright voxels surround its middle.
TEST(Bones, TheRimLeavesOutMissedBone) {
    CtVolume ct({Index3(40), Vec3(0.001), Vec3(0.0)}, 50);
    Mask bones(ct.grid);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const bool inside = i.x >= 10 && i.x < 24 && i.y >= 10 && i.y < 30 && i.z >= 10 && i.z < 30;
        if (inside) ct[i] = 400;
        bones[i] = inside && i.x < 15;
    });
    for (const ScanBlur& blur : {ScanBlur{}, ScanBlur{.across_m = 0.00155}}) {
        const Mask rim = brightRim(ct, Mask(ct.grid, 1), bones, 150.0, blur);
        for (int x = 15; x < 24; ++x)
            EXPECT_FALSE((rim[{x, 20, 20}])) << x;
    }
}

// A rib along x with ridges that are one voxel high and three long. In thick slices, interpolation leaves
// such ridges.
struct RoughRib {
    Mask rib, rough;
    explicit RoughRib(double spacing_m) : rib({Index3(60, 40, 40), Vec3(spacing_m), Vec3(0.0)}) {
        forEachVoxel(rib.grid,
                     [&](const Index3& i) { rib[i] = std::hypot((i.y - 20) / 4.3, (i.z - 20) / 7.3) < 1.0; });
        rough = rib;
        for (int x = 10; x < 50; ++x)
            if (x % 6 < 3) rough[{x, 25, 20}] = 1;
    }
};
Mask smoothedIn(const Mask& bone, double within_m, double across_m) {
    return smoothedSurface(bone, Mask(bone.grid, 1), {.within_m = within_m, .across_m = across_m});
}

TEST(Bones, BumpsAreSmoothedInASoftScanOnly) {
    const RoughRib fine(0.001), coarse(0.0015), finest(0.0005);
    EXPECT_EQ(smoothedIn(fine.rough, 0.0007, 0.0008).voxels, fine.rough.voxels);
    EXPECT_EQ(smoothedIn(finest.rough, 0.0007, 0.0008).voxels, finest.rough.voxels);
    EXPECT_EQ(smoothedIn(coarse.rough, 0.0011, 0.0011).voxels, coarse.rough.voxels) << "wide voxels blur too";
    const double whole_ml = volume_ml(fine.rib);
    for (const auto& [within_m, across_m] : {std::pair(0.0007, 0.0016), {0.0011, 0.0011}}) {
        const Mask smoothed = smoothedIn(fine.rough, within_m, across_m);
        EXPECT_EQ(smoothed.voxels, smoothedIn(fine.rib, within_m, across_m).voxels) << "the ridges are gone";
        EXPECT_NEAR(volume_ml(smoothed), whole_ml, 0.03 * whole_ml) << "the rib is as thick as before";
    }
    const Mask none(fine.rib.grid);
    const Mask closed = smoothedSurface(fine.rough, none, {.within_m = 0.0011, .across_m = 0.0011});
    EXPECT_EQ(countVoxels(subtract(closed, fine.rough)), 0u) << "nothing may be added";
}

// Laminae and the tips of ribs are as thin as a voxel.
TEST(Bones, SmoothingKeepsThinBone) {
    Mask thin({Index3(30), Vec3(0.001), Vec3(0.0)});
    forEachVoxel(thin.grid, [&](const Index3& i) {
        thin[i] = (i.z == 8 && i.x > 4 && i.x < 25 && i.y > 4 && i.y < 25) ||  // a plate
                  (i.z > 17 && i.z < 20 && i.y > 14 && i.y < 17);              // a rod
    });
    EXPECT_EQ(countVoxels(subtract(thin, smoothedIn(thin, 0.0011, 0.0011))), 0u);
}

// The bumps are as bright as the bone, so only smoothing removes them.
TEST(Bones, BumpsOfABoneInThickSlicesAreMuscle) {
    const RoughRib bone(0.001);
    CtVolume ct(bone.rib.grid, 55);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        if (bone.rough.voxels[i]) ct.voxels[i] = 900;
    const auto bumps = [&](double across_m) {
        const Mask found = findBones(ct, Mask(ct.grid, 1), {.within_m = 0.0007, .across_m = across_m}).all;
        return countVoxels(intersect(found, subtract(bone.rough, bone.rib)));
    };
    EXPECT_GT(bumps(0.0007), 10u);
    EXPECT_EQ(bumps(0.0016), 0u);
}

// A cortex much darker than the cortex beside it is no blurred rim.
TEST(Bones, ADarkPartOfTheCortexIsKept) {
    const RibPhantom rib(true, 400.0f);
    const Bones b = findBones(rib.ct, Mask(rib.ct.grid, 1), {});
    std::size_t kept = 0, cortex = 0;
    forEachVoxel(rib.ct.grid, [&](const Index3& i) {
        if (i.z % 8 != 5 || RibPhantom::share(i.x, i.y, i.z, 0.0) >= 1.0) return;
        if (RibPhantom::share(i.x, i.y, i.z, -1.5) < 1.0) return;
        ++cortex, kept += b.all[i];
    });
    EXPECT_GT(double(kept), 0.9 * double(cortex));
}

TEST(Bones, DarkScanHasNoBones) {
    const CtVolume ct({Index3(30), Vec3(0.002), Vec3(0.0)}, 50);
    const Bones b = findBones(ct, Mask(ct.grid, 1), {});
    EXPECT_EQ(countVoxels(b.all), 0u);
    EXPECT_TRUE(b.ribs.empty());
    EXPECT_EQ(b.notes.size(), 3u);  // notes: no canal, no left ribs, no right ribs
    EXPECT_EQ(findBones(ct, Mask(ct.grid), {}).notes.size(), 1u);
}

// In a body that fills the CT, all of it outside the fascia.
Mask findCartilage(const CtVolume& ct, const Bones& b) {
    const Mask everywhere(ct.grid, 1), ends = unite(b.ribs_right, unite(b.ribs_left, b.sternum));
    return costalCartilage(ct, everywhere, {}, Mask(ct.grid), {b.all, ends, b.spine, b.canal});
}

// A rod along x in front: bone, then cartilage, then muscle again. A second rod is cartilage only. A dense
// layer of muscle, 2 mm thick, lies on the first rod.
TEST(Bones, CartilageContinuesTheRib) {
    CtVolume ct({Index3(90, 60, 50), Vec3(0.001), Vec3(0.0)}, 55);
    Bones b;
    for (Mask* m : {&b.all, &b.spine, &b.canal, &b.ribs_right, &b.ribs_left, &b.sternum})
        *m = Mask(ct.grid);
    Mask cartilage(ct.grid);
    forEachVoxel(VoxelBox{{10, 0, 0}, {79, 59, 49}}, [&](const Index3& i) {
        if (std::hypot(i.y - 45, i.z - 15) < 5.0 && i.x < 70) {
            ct[i] = i.x < 40 ? 600 : 100;
            (i.x < 40 ? b.ribs_right : cartilage)[i] = 1;
        }
        if (std::hypot(i.y - 45, i.z - 35) < 5.0) ct[i] = 100;
        if ((i.y == 45 || i.y == 46) && i.z >= 20 && i.z < 26) ct[i] = 95;
    });
    b.all = b.ribs_right;
    const Mask found = findCartilage(ct, b);
    EXPECT_GT(compare(cartilage, found).dice, 0.85);
    EXPECT_FALSE((found[{50, 45, 35}]));
    EXPECT_FALSE((found[{55, 45, 22}]));
    ct.grid.spacing_m = Vec3(0.0015);
    for (Mask* m : {&b.all, &b.spine, &b.canal, &b.ribs_right, &b.ribs_left, &b.sternum})
        m->grid = ct.grid;
    EXPECT_EQ(countVoxels(findCartilage(ct, b)), 0u);
}

// A blurred, noisy scan of a rod: rib, then cartilage with a calcified shell, then plain cartilage.
class CalcifiedCartilage : public testing::TestWithParam<float> {};
INSTANTIATE_TEST_SUITE_P(Shell, CalcifiedCartilage, testing::Values(330.0f, 600.0f));

TEST_P(CalcifiedCartilage, HasARimOfMuscle) {
    CtVolume ct({Index3(100, 60, 40), Vec3(0.001), Vec3(0.0)}, 55);
    Bones b;
    for (Mask* m : {&b.all, &b.spine, &b.canal, &b.ribs_right, &b.ribs_left, &b.sternum})
        *m = Mask(ct.grid);
    FloatVolume hu = toFloat(ct);
    Mask calcified(ct.grid), plain(ct.grid);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        const double out = std::hypot(i.y - 42, i.z - 20) - 6.0;
        if (out >= 0.0) return;
        (i.x < 30 ? b.ribs_right : i.x < 60 ? calcified : plain)[i] = 1;
        hu[i] = i.x < 30 ? 600.0f : i.x >= 60 || out < -1.5 ? 110.0f : GetParam();
    });
    for (const int axis : {0, 1, 2})
        parallelLines(1, hu.grid.dims, axis, hu.voxels.data(), smoothLine);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i)
        ct.voxels[i] = std::int16_t(std::lround(hu.voxels[i] + 12.0 * test::noiseAt(i)));
    b.all = b.ribs_right;
    const Mask everywhere(ct.grid, 1), found = findCartilage(ct, b);
    const auto share = [&](const Mask& of) {
        return double(countVoxels(intersect(found, of))) / double(countVoxels(of));
    };
    Mask beside = inverted(unite(unite(calcified, plain), b.all));
    forEachVoxel(ct.grid, [&](const Index3& i) { beside[i] = beside[i] && i.x >= 30 && i.x < 58; });
    EXPECT_GT(share(calcified), 0.9);
    EXPECT_GT(share(plain), 0.75);
    // The muscle around the shell is as dense as cartilage.
    EXPECT_LT(double(countVoxels(intersect(found, beside))), 0.02 * double(countVoxels(calcified)));
    // Where it is as bright as bone, it is labelled: no voxel left without a label counts as bone.
    const Mask known = unite(found, cartilageRim(ct, everywhere, {}, found, b.all, kBone_hu));
    std::size_t bright = 0, left = 0;
    for (std::size_t i = 0; i < beside.voxels.size(); ++i) {
        if (!beside.voxels[i] || found.voxels[i] || ct.voxels[i] < kBone_hu) continue;
        ++bright, left += !known.voxels[i];
    }
    EXPECT_EQ(bright > 0, GetParam() > 500.0f);
    EXPECT_EQ(left, 0u);
}

// A plate of cartilage, then a layer as bright as blurred muscle. In the layer are a part of an organ and a
// piece of missed bone.
TEST(Bones, ARimOfCartilageCoversNoOrganAndNoMissedBone) {
    CtVolume ct({Index3(40, 30, 20), Vec3(0.001), Vec3(0.0)}, 55);
    Mask cartilage(ct.grid), organ(ct.grid), bone(ct.grid), layer(ct.grid);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        cartilage[i] = i.y < 10;
        layer[i] = i.y == 10;
        organ[i] = layer[i] && i.x < 10;
        bone[i] = layer[i] && i.x >= 30;
        ct[i] = cartilage[i] ? 110 : !layer[i] ? 55 : bone[i] ? 520 : 300;
    });
    const Mask everywhere(ct.grid, 1);
    const Mask rim = cartilageRim(ct, everywhere, {}, cartilage, organ, kBone_hu);
    EXPECT_EQ(rim.voxels, subtract(layer, unite(organ, bone)).voxels);
    EXPECT_EQ(countVoxels(cartilageRim(ct, everywhere, {}, Mask(ct.grid), organ, kBone_hu)), 0u);
}

// Calcium all around the aorta, so that it looks like a bone with marrow.
TEST(Bones, ACalcifiedAortaIsNoVertebra) {
    CtVolume ct = test::seededTorso().ct;
    const Mask aorta = withLabel(test::seededTorso().labels, std::uint8_t(Id::aorta));
    const Mask wall = subtract(aorta, eroded(aorta, 1.5 * ct.grid.spacing_m.x));
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        if (wall.voxels[i]) ct.voxels[i] = 700;
    const Bones b = findBones(ct, test::seededBody(), {});
    EXPECT_LT(double(countVoxels(intersect(b.all, aorta))), 0.05 * double(countVoxels(aorta)));
    EXPECT_GT(compare(b.spine, test::seededBones().spine).dice, 0.97);
}

// Calcified cartilage joins the ribs of both sides to the spine. The middle of all that is in front of the
// spine.
TEST(Bones, RibsThatAreJoinedInFrontStayBone) {
    CtVolume ct = test::seededTorso().ct;
    const Mask cartilage = withLabel(test::seededTorso().labels, std::uint8_t(Id::cartilage));
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        if (cartilage.voxels[i]) ct.voxels[i] = 600;
    const Mask found = findBones(ct, test::seededBody(), {}).all, usual = test::seededBones().all;
    EXPECT_GT(double(countVoxels(intersect(found, usual))), 0.9 * double(countVoxels(usual)));
}

TEST(Bones, MatchReferencePatient) {
    const Bones& b = test::seededBones();
    EXPECT_GT(test::diceWithTruth({Id::spine, Id::ribsRight, Id::ribsLeft, Id::sternum}, b.all), 0.80);
    EXPECT_GT(test::diceWithTruth({Id::spine}, b.spine), 0.82);
    EXPECT_GT(test::diceWithTruth({Id::spinalCanal}, b.canal), 0.80);
    EXPECT_GT(test::diceWithTruth({Id::sternum}, b.sternum), 0.70);
    EXPECT_EQ(countVoxels(b.other), 0u);
    std::set<int> right, left;
    for (const Rib& rib : b.ribs) {
        (rib.right ? right : left).insert(rib.number);
        ASSERT_GT(rib.centre_line_m.size(), 5u);
        EXPECT_EQ(rib.centre_line_m.back().x > 0.0, rib.right);
    }
    const std::set<int> all{5, 6, 7, 8, 9, 10, 11, 12};  // the ribs inside the scan
    EXPECT_EQ(right, all);
    EXPECT_EQ(left, all);
}

}  // namespace
}  // namespace stylet::modeller
