#include "app/modeller/segmentation/liver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/liver_border.h"
#include "app/modeller/segmentation/liver_neighbours.h"
#include "app/modeller/wall/fascia_spline.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// Fat, 60 x 60 x 50 voxels of 3 mm, with a ball of liver in the centre.
constexpr double kLiverRadius_m = 0.050;
const Vec3 kLiverMiddle(0.09, 0.09, 0.075);

void paintBall(CtVolume& ct, const Vec3& middle, double radius_m, std::int16_t hu) {
    forEachVoxel(ct.grid, [&](const Index3& i) {
        if (glm::length(ct.grid.centre(i) - middle) < radius_m) ct[i] = hu;
    });
}

CtVolume fatWithALiver(std::int16_t liver_hu = 110) {
    CtVolume ct({Index3(60, 60, 50), Vec3(0.003), Vec3(0.0)}, -100);
    paintBall(ct, kLiverMiddle, kLiverRadius_m, liver_hu);
    return ct;
}

Liver segment(const CtVolume& ct, const AtlasPrior& prior = {}) {
    const Mask all(ct.grid, 1), none(ct.grid);
    return findLiver(ct, all, none, none, prior);
}

TEST(Liver, WithoutAtlasTheLargestThickOrganIsUsed) {
    const CtVolume ct = fatWithALiver();
    const Liver liver = segment(ct);
    EXPECT_NEAR(liver.mean_hu, 110.0, 3.0);
    EXPECT_NEAR(volume_ml(liver.mask), 523.6, 25.0);
    ASSERT_EQ(liver.notes.size(), 1u);
}

// At 80 kV (the second liver), a tumour differs more from the liver.
TEST(Liver, IncludesVesselsAndTumoursButNotAttachedOrgans) {
    for (const auto& [liver_hu, tumour_hu] : {std::pair<std::int16_t, std::int16_t>(110, 65), {132, 56}}) {
        CtVolume ct = fatWithALiver(liver_hu);
        const double whole_ml = volume_ml(segment(ct).mask);
        paintBall(ct, kLiverMiddle + Vec3(0.015, 0, 0), 0.009, 60);          // a tumour inside
        paintBall(ct, kLiverMiddle + Vec3(0, 0, -0.020), 0.005, 190);        // a vessel
        paintBall(ct, kLiverMiddle + Vec3(-0.036, 0, 0), 0.014, tumour_hu);  // at the surface, clipped to it
        for (const double y_m : {0.054, 0.060, 0.066, 0.072})
            paintBall(ct, kLiverMiddle + Vec3(0, y_m, 0), 0.0055, liver_hu);  // same brightness, touches it
        const CtVolume round = fatWithALiver();
        for (std::size_t i = 0; i < ct.voxels.size(); ++i)
            if (round.voxels[i] == -100 && ct.voxels[i] == tumour_hu) ct.voxels[i] = -100;
        const Liver liver = segment(ct);
        EXPECT_NEAR(volume_ml(liver.mask), whole_ml, 0.03 * whole_ml) << liver_hu;
        for (const Vec3& at : {Vec3(0.015, 0, 0), Vec3(0, 0, -0.020), Vec3(-0.036, 0, 0)})
            EXPECT_EQ(liver.mask.nearestOr(kLiverMiddle + at, 0), 1) << liver_hu << " HU, " << at.x;
        EXPECT_EQ(liver.mask.nearestOr(kLiverMiddle + Vec3(0, 0.072, 0), 0), 0) << liver_hu;
    }
}

// A tumour as wide as 44 mm takes the place of the liver's outline. Outside it lies fat, or muscle that looks
// like the tumour but for 15 HU.
TEST(Liver, IncludesAllOfAWideTumourAtItsSurface) {
    const Vec3 middle = kLiverMiddle + Vec3(-0.036, 0, 0);
    for (const std::int16_t outside_hu : {std::int16_t{-100}, std::int16_t{50}}) {
        CtVolume ct = fatWithALiver();
        Mask whole(ct.grid), tumour(ct.grid);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const Vec3 at = ct.grid.centre(i);
            whole[i] = ct[i] == 110;
            tumour[i] = whole[i] && glm::length(at - middle) < 0.022;
            if (tumour[i]) ct[i] = 65;
            if (!whole[i] && glm::length(at - kLiverMiddle) < kLiverRadius_m + 0.012) ct[i] = outside_hu;
        });
        const Mask found = segment(ct).mask;
        EXPECT_GT(volume_ml(intersect(found, tumour)), 0.93 * volume_ml(tumour)) << outside_hu;
        EXPECT_LT(volume_ml(subtract(found, whole)), 0.02 * volume_ml(whole)) << outside_hu;
    }
}

// A stomach as bright as a tumour is pressed into the liver. The atlases know it.
TEST(Liver, AnOrganPressedIntoItIsNoTumour) {
    CtVolume ct = fatWithALiver();
    const std::vector<std::int16_t> round = ct.voxels;
    const Vec3 middle = kLiverMiddle + Vec3(-0.055, 0, 0);
    paintBall(ct, middle, 0.025, 65);
    AtlasPrior prior{
        ct.grid, std::vector<FloatVolume>(kOrgans, FloatVolume(ct.grid)), FloatVolume(ct.grid, 1.0f), {"a"}};
    Mask stomach(ct.grid);
    forEachVoxel(ct.grid, [&](const Index3& i) {
        stomach[i] = ct[i] == 65;
        const Organ organ = stomach[i]                        ? Organ::stomach
                            : round[ct.grid.offset(i)] == 110 ? Organ::liver
                                                              : Organ::elsewhere;
        prior.probability[std::size_t(organ)][i] = 1.0f;
    });
    const Mask found = segment(ct, prior).mask;
    EXPECT_LT(volume_ml(intersect(found, stomach)), 0.05 * volume_ml(stomach));
}

TEST(Liver, MissingLiverIsReported) {
    CtVolume ct = fatWithALiver();
    std::fill(ct.voxels.begin(), ct.voxels.end(), std::int16_t{-100});
    Liver liver = segment(ct);
    EXPECT_EQ(countVoxels(liver.mask), 0u);
    EXPECT_EQ(liver.notes.back(), "no liver: nothing in the scan is like one where it should lie");
    paintBall(ct, kLiverMiddle, 0.026, 110);
    liver = segment(ct);
    EXPECT_EQ(countVoxels(liver.mask), 0u);
}

TEST(LiverBorder, MovesToTheEdge) {
    const CtVolume ct = fatWithALiver();
    const Mask open(ct.grid, 1);
    for (const double off_m : {-0.005, 0.005}) {
        Mask first(ct.grid);
        for (int z = 0; z < 50; ++z)
            for (int y = 0; y < 60; ++y)
                for (int x = 0; x < 60; ++x)
                    first[{x, y, z}] =
                        glm::length(ct.grid.centre({x, y, z}) - kLiverMiddle) < kLiverRadius_m + off_m;
        const Mask liver = refineLiver(ct, open, first, {110.0f, 5.0f}, 0.008, kUsualBlur_m);
        EXPECT_NEAR(volume_ml(liver), 523.6, 16.0) << off_m;
    }
}

// A ball of liver of 112 HU in voxels of 1 mm, blurred and noisy. From its surface outwards: fat, then tissue
// of `thickness_m`, then a third tissue.
struct LayeredLiver {
    static constexpr double kRadius_m = 0.024;
    FloatVolume hu;
    Mask truth;

    LayeredLiver(double fat_m, float tissue_hu, double thickness_m = 1.0, float beyond_hu = 0.0f,
                 int blurs = 1)
        : hu(test::cube(68)), truth(hu.grid) {
        FloatVolume ideal(hu.grid);
        for (std::size_t i = 0; i < ideal.voxels.size(); ++i) {
            const double out_m = depth_m(i);
            truth.voxels[i] = out_m < 0.0;
            ideal.voxels[i] = out_m < 0.0                   ? 112.0f
                              : out_m < fat_m               ? -105.0f
                              : out_m < fat_m + thickness_m ? tissue_hu
                                                            : beyond_hu;
        }
        for (int n = 0; n < blurs; ++n)
            for (const int axis : {0, 1, 2})
                parallelLines(1, hu.grid.dims, axis, ideal.voxels.data(), smoothLine);
        for (std::size_t i = 0; i < ideal.voxels.size(); ++i)
            hu.voxels[i] = ideal.voxels[i] + 11.0f * float(test::noiseAt(i));
    }

    // Distance from the surface, positive outside.
    double depth_m(std::size_t voxel) const {
        return glm::length(hu.grid.centre(hu.grid.voxelAt(voxel)) - Vec3(0.0335)) - kRadius_m;
    }
    Mask ball(double larger_m) const {
        return maskWhere(hu.grid, [&](std::size_t i) { return depth_m(i) < larger_m; });
    }
    Mask fit(const Mask& cut, double blur_m = kUsualBlur_m) const {
        return fitBorder(hu, Mask(hu.grid, 1), cut, {112.0f, 11.0f}, blur_m);
    }
    // Mean distance by which the border of `liver` lies outside the true one.
    double error_m(const Mask& liver) const {
        const double more = double(countVoxels(liver)) - double(countVoxels(truth));
        return 1e-9 * more / (4.0 * std::numbers::pi * kRadius_m * kRadius_m);
    }
};

TEST(LiverBorder, IsFittedBesideAThinFilmOfFat) {
    for (const double fat_m : {0.0, 0.001, 0.002, 0.010}) {
        const LayeredLiver liver(fat_m, 60.0f);
        for (const double off_m : {-0.0012, 0.0008})
            EXPECT_NEAR(liver.error_m(liver.fit(liver.ball(off_m))), 0.0, 0.00025) << fat_m << " " << off_m;
    }
}

// Three times the variance of the usual blur. With the usual blur, the liver ends too early at a film of fat.
TEST(LiverBorder, IsFittedInASoftScan) {
    double usual_m = 0.0;
    for (const double fat_m : {0.0, 0.001, 0.003}) {
        const LayeredLiver liver(fat_m, 60.0f, 1.0, 0.0f, 3);
        const Mask cut = liver.ball(-0.0012);
        EXPECT_NEAR(liver.error_m(liver.fit(cut, 0.00122)), 0.0, 0.00025) << fat_m;
        usual_m = std::max(usual_m, std::fabs(liver.error_m(liver.fit(cut))));
    }
    EXPECT_GT(usual_m, 0.0006);
}

TEST(LiverBorder, IsFittedBesideABrighterOrgan) {
    const LayeredLiver kidney(0.0, 190.0f);
    for (const double off_m : {-0.001, 0.001})
        EXPECT_NEAR(kidney.error_m(kidney.fit(kidney.ball(off_m))), 0.0, 0.00025) << off_m;
}

TEST(LiverBorder, StaysWhereTheProfileReachesLung) {
    const LayeredLiver liver(0.0, 108.0f, 0.003, -820.0f);  // a diaphragm that looks like liver
    const Mask cut = liver.ball(0.0004);
    EXPECT_EQ(liver.fit(cut).voxels, cut.voxels);
}

TEST(LiverBorder, StaysWhereNothingIsVisible) {
    const LayeredLiver liver(0.0, 112.0f);
    const Mask cut = liver.ball(0.0);
    EXPECT_NEAR(liver.error_m(liver.fit(cut)), 0.0, 0.0004);
}

TEST(LiverBorder, IsNotMovedFartherThanItsLimit) {
    const LayeredLiver liver(0.010, 60.0f);
    const Mask fitted = liver.fit(liver.ball(-0.004));
    EXPECT_EQ(countVoxels(subtract(fitted, liver.ball(-0.004 + 0.0025 + 0.001))), 0u);
}

TEST(LiverBorder, DoesNotEnterClosedVoxels) {
    const LayeredLiver liver(0.0, 60.0f);
    Mask open(liver.hu.grid, 1);
    for (std::size_t i = 0; i < open.voxels.size(); ++i)
        open.voxels[i] = liver.hu.grid.voxelAt(i).x < 34;
    const Mask cut = intersect(liver.ball(-0.001), open);
    const Mask fitted = fitBorder(liver.hu, open, cut, {112.0f, 11.0f}, kUsualBlur_m);
    EXPECT_GT(countVoxels(fitted), countVoxels(cut));
    EXPECT_EQ(countVoxels(subtract(fitted, open)), 0u);
}

// A shell of liver around two stones: one almost touches it, one lies in the middle of the cavity.
TEST(Liver, AStoneInACavityIsNotCalcifiedLiver) {
    const Grid g = test::cube(68);
    const auto ball = [&](double x_m, double radius_m) {
        const Vec3 middle(x_m, 0.0335, 0.0335);
        return maskWhere(
            g, [&](std::size_t i) { return glm::length(g.centre(g.voxelAt(i)) - middle) < radius_m; });
    };
    const Mask liver = subtract(ball(0.0335, 0.031), ball(0.0335, 0.022));
    const Mask touching = ball(0.0160, 0.003), loose = ball(0.0380, 0.003);
    EXPECT_EQ(calcifiedLiver(unite(touching, loose), liver).voxels, touching.voxels);
}

TEST(LiverNeighbours, SigmaFilterAveragesNoiseAndKeepsEdges) {
    const Mask all({Index3(12, 12, 12), Vec3(0.003), Vec3(0.0)}, 1);
    FloatVolume image(all.grid);
    for (std::size_t i = 0; i < image.voxels.size(); ++i)
        image.voxels[i] = (i % 12 < 6 ? 50.0f : 115.0f) + ((i * 7919 % 13) < 6 ? 8.0f : -8.0f);
    const FloatVolume filtered = sigmaFiltered(image, all, 25.0f, 1);
    for (int z = 1; z < 11; ++z)
        for (int x = 1; x < 11; ++x)
            EXPECT_NEAR((filtered[{x, 6, z}]), x < 6 ? 50.0f : 115.0f, 6.5f);
    EXPECT_EQ(sigmaFiltered(image, Mask(all.grid), 25.0f, 1).voxels, image.voxels);
}

TEST(LiverNeighbours, BrighterLobeIsBiasCorrected) {
    const Grid grid{Index3(40, 10, 10), Vec3(0.003), Vec3(0.0)};
    FloatVolume hu(grid);
    Mask core(grid);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i) {
        hu.voxels[i] = i % 40 < 12 ? 125.0f : 115.0f;
        core.voxels[i] = i % 40 < 28;
    }
    const FloatVolume level = correctBias(hu, core, 115.0f, 2);
    EXPECT_NEAR((level[{3, 5, 5}]), 115.0f, 0.5f);
    EXPECT_NEAR((level[{22, 5, 5}]), 115.0f, 0.5f);
    EXPECT_NEAR((level[{38, 5, 5}]), 115.0f, 0.1f);
}

// A ball with a lobe and an equally thick lump (24 mm), in front and at the side. Only the lump may continue
// into similar tissue outside the liver.
TEST(LiverNeighbours, PriorAndNeighboursTellALeakFromALobe) {
    Mask liver({Index3(70, 60, 50), Vec3(0.003), Vec3(0.0)}), similar = liver;
    FloatVolume surely(liver.grid, 0.9f), unlikely = surely;
    const Mask nothing(liver.grid);
    forEachVoxel(liver.grid, [&](const Index3& i) {
        const Vec3 from = liver.grid.centre(i) - kLiverMiddle;
        const bool lump = std::hypot(from.y, from.z) < 0.012 && from.x > 0.0;
        const bool lobe = std::hypot(from.x, from.z) < 0.012 && from.y > 0.0;
        liver[i] = glm::length(from) < kLiverRadius_m || (lump && from.x < 0.070) || (lobe && from.y < 0.075);
        similar[i] = lump && from.x >= 0.070;
        if (lump) unlikely[i] = 0.4f;
    });
    for (const Mask& beyond : {similar, nothing}) {
        const Mask lumps = findLeakedLumps(liver, beyond, unlikely, 0.015);
        EXPECT_EQ(lumps.nearestOr(kLiverMiddle + Vec3(0.062, 0, 0), 0), 1);
        EXPECT_EQ(lumps.nearestOr(kLiverMiddle + Vec3(0.045, 0, 0), 0), 0);
        EXPECT_EQ(lumps.nearestOr(kLiverMiddle + Vec3(0, 0.062, 0), 0), 0);
    }
    EXPECT_EQ(countVoxels(findLeakedLumps(liver, nothing, surely, 0.015)), 0u);
}

// A lobe of 380 ml behind a neck of 16 mm, which the atlases know. And a liver without a thick part.
TEST(LiverNeighbours, AKnownLobeBehindANarrowNeckIsKept) {
    Mask liver({Index3(80, 50, 50), Vec3(0.003), Vec3(0.0)}), thin = liver;
    forEachVoxel(liver.grid, [&](const Index3& i) {
        const Vec3 p = liver.grid.centre(i);
        liver[i] = glm::length(p - Vec3(0.065, 0.075, 0.075)) < 0.055 ||
                   glm::length(p - Vec3(0.180, 0.075, 0.075)) < 0.045 ||
                   (std::hypot(p.y - 0.075, p.z - 0.075) < 0.008 && p.x > 0.065 && p.x < 0.180);
        thin[i] = glm::length(p - Vec3(0.065, 0.075, 0.075)) < 0.013;
    });
    const Mask nothing(liver.grid);
    EXPECT_EQ(countVoxels(findLeakedLumps(liver, nothing, FloatVolume(liver.grid, 0.7f), 0.015)), 0u);
    EXPECT_GT(countVoxels(findLeakedLumps(liver, nothing, FloatVolume(liver.grid, 0.3f), 0.015)), 0u);
    EXPECT_EQ(countVoxels(findLeakedLumps(thin, nothing, FloatVolume(liver.grid, 0.3f), 0.015)), 0u);
}

// A thick disc that thins out to its rim, which ends in similar tissue, like a lobe that touches the spleen.
TEST(LiverNeighbours, TipThatTouchesSimilarTissueIsNoLeak) {
    constexpr double kRim_m = 0.060, kSlope = 0.7;
    Mask liver({Index3(80, 80, 40), Vec3(0.002), Vec3(0.0)}), similar = liver;
    const Vec3 middle(0.080, 0.080, 0.040);
    forEachVoxel(liver.grid, [&](const Index3& i) {
        const Vec3 from = liver.grid.centre(i) - middle;
        const double radius = std::hypot(from.x, from.y);
        const double half_m = std::min(0.030, 0.002 + kSlope * (kRim_m - radius));
        liver[i] = radius < kRim_m && std::fabs(from.z) < half_m;
        similar[i] = radius >= kRim_m && std::fabs(from.z) < 0.010;
    });
    const FloatVolume possible(liver.grid, 0.4f), surely(liver.grid, 0.7f);
    EXPECT_EQ(countVoxels(findLeakedLumps(liver, similar, possible, 0.015)), 0u);
    // Similar tissue all around.
    EXPECT_GT(countVoxels(findLeakedLumps(liver, inverted(liver), possible, 0.015)), 0u);
    EXPECT_EQ(countVoxels(findLeakedLumps(liver, inverted(liver), surely, 0.015)), 0u);
}

// Organ positions of another seed: a prior without registration.
AtlasPrior makePrior(const AtlasImage& atlas) {
    AtlasPrior prior;
    prior.grid = atlas.feature.grid;
    prior.known = FloatVolume(prior.grid, 1.0f);
    prior.probability.assign(kOrgans, FloatVolume(prior.grid));
    prior.used = {atlas.name};
    forEachVoxel(prior.grid, [&](const Index3& i) {
        const std::uint8_t organ = atlas.organ.nearestOr(prior.grid.centre(i), 0);
        prior.probability[organ][i] = 1.0f;
    });
    return prior;
}

// Hoops for ribs in the upper part of a round body.
struct Hoops {
    static constexpr double kRib_m = 0.100, kBody_m = 0.120, kThick_m = 0.008, kApart_m = 0.028,
                            kLowest_m = 0.090;
    const Grid g{Index3(130, 130, 90), Vec3(0.002), Vec3(-0.129, -0.129, 0.0)};
    CtVolume ct{g, std::int16_t(-1000)};
    Mask body{g}, ribs{g}, lungs{g};
    Hoops() {
        forEachVoxel(g, [&](const Index3& i) {
            const double height = g.centre(i).z - kLowest_m;
            body[i] = radius(i) < kBody_m;
            ribs[i] = height >= 0.0 && std::fmod(height, kApart_m) < kThick_m && radius(i) > kRib_m &&
                      radius(i) < kRib_m + kThick_m;
            if (body[i]) ct[i] = ribs[i] ? 400 : 60;
        });
    }
    double radius(const Index3& i) const { return std::hypot(g.centre(i).x, g.centre(i).y); }
    Mask open(double gap_m) const {
        Mask mask = body;
        removeOutsideRibs({ct, body, ribs, lungs}, gap_m, {&mask});
        return mask;
    }
};

TEST(LiverNeighbours, NothingStaysOutsideTheRibs) {
    const Hoops h;
    for (const double gap_m : {0.0, 0.006}) {
        const Mask open = h.open(gap_m);
        int outside = 0, inside = 0, below = 0;
        forEachVoxel(h.g, [&](const Index3& i) {
            if (!h.body[i]) return;
            const double z = h.g.centre(i).z;
            if (z > h.kLowest_m) outside += open[i] && h.radius(i) > h.kRib_m - gap_m;
            if (z > h.kLowest_m) inside += !open[i] && h.radius(i) < h.kRib_m - gap_m - 0.005;
            if (z < h.kLowest_m - 0.030) below += !open[i];
        });
        EXPECT_EQ(outside, 0) << gap_m;
        EXPECT_EQ(inside, 0) << gap_m;
        EXPECT_EQ(below, 0) << gap_m;
    }
}

// A liver inside the ribs, and a wall beside it that has the liver's brightness between the ribs and beyond
// them. The first cut takes it in, because the prior is wrong and says that all is liver.
TEST(Liver, DoesNotLeakThroughTheRibs) {
    Hoops h;
    const auto isLeak = [&](const Index3& i) {
        const Vec3 p = h.g.centre(i);
        return p.x > 0.0 && std::fabs(p.y) < 0.040 && h.radius(i) > h.kRib_m && h.radius(i) < h.kBody_m;
    };
    Mask truth(h.g);
    forEachVoxel(h.g, [&](const Index3& i) {
        const Vec3 p = h.g.centre(i);
        truth[i] = glm::length(p - Vec3(0.050, 0.0, 0.110)) < 0.055 && h.radius(i) < h.kRib_m;
        if (h.body[i] && !h.ribs[i]) h.ct[i] = truth[i] || isLeak(i) ? 110 : -100;
    });
    AtlasPrior wrong{h.g, std::vector<FloatVolume>(kOrgans, FloatVolume(h.g)), FloatVolume(h.g, 1.0f), {"a"}};
    wrong.probability[std::size_t(Organ::liver)] = FloatVolume(h.g, 1.0f);
    const Mask none(h.g);
    const auto find = [&](const Mask& ribs) { return findLiver(h.ct, h.body, h.lungs, ribs, wrong); };
    const Liver leaked = find(none), kept = find(h.ribs);
    const auto outside_ml = [&](const Liver& l) { return volume_ml(subtract(l.mask, truth)); };
    EXPECT_GT(outside_ml(leaked), 20.0);
    EXPECT_LT(outside_ml(kept), 3.0);
    EXPECT_GT(compare(truth, kept.mask).dice, 0.95);
    ASSERT_FALSE(kept.notes.empty());
    EXPECT_TRUE(kept.notes.back().ends_with("outside the ribs' inner side were removed"))
        << kept.notes.back();
}

// A stent in front of the middle is not a rib if the liver lies outside it. The liver that took in the wall
// does not make the ribs false.
TEST(WallBones, ExcludeAStentButNoRib) {
    Hoops h;
    const Mask ribs = h.ribs;
    forEachVoxel(h.g, [&](const Index3& i) {
        const Vec3 p = h.g.centre(i);
        if (std::hypot(p.x, p.z - 0.120) < 0.006 && p.y > 0.050 && p.y < 0.070) h.ribs[i] = 1;
    });
    const Mask leaked = eroded(h.body, 0.008), stent = subtract(h.ribs, ribs);
    ASSERT_GT(countVoxels(stent), 0u);
    EXPECT_EQ(wallBones({h.ct, h.body, h.ribs, leaked}).voxels, ribs.voxels);
    EXPECT_EQ(wallBones({h.ct, h.body, h.ribs, h.lungs}).voxels, h.ribs.voxels)
        << "without an organ outside it, it could be a rib";
    Mask drain(h.g);  // through the wall into the middle of the liver
    forEachVoxel(h.g, [&](const Index3& i) {
        const Vec3 p = h.g.centre(i);
        drain[i] = std::hypot(p.y, p.z - 0.106) < 0.003 && p.x > 0.020 && p.x < 0.115;
    });
    EXPECT_EQ(wallBones({h.ct, h.body, unite(ribs, drain), leaked}).voxels, ribs.voxels);
    const FasciaInput with{h.ct, h.body, h.ribs, leaked}, without{h.ct, h.body, ribs, leaked};
    EXPECT_EQ(fitWall(with).radius_m, fitWall(without).radius_m);
    EXPECT_EQ(fitFascia(with).control_m, fitFascia(without).control_m);
}

TEST(Liver, MatchesReferencePatient) {
    const AtlasPrior prior = makePrior(AtlasImage(test::stillPatient(2, 0.0025), {}));
    const patient::Package& torso = test::seededTorso();
    const Mask lungs = test::seededTruth({Id::lungRight, Id::lungLeft});
    const Mask bones = test::seededTruth({Id::ribsRight, Id::ribsLeft, Id::spine, Id::sternum});
    const Liver liver = findLiver(torso.ct, test::seededBody(), lungs, bones, prior);
    const Agreement a = compare(wholeLiver(torso.labels, torso.label_table), liver.mask);
    EXPECT_GT(a.dice, 0.94);
    EXPECT_LT(a.mean_surface_m, 0.0025);
    EXPECT_TRUE(liver.notes.empty());
    EXPECT_NEAR(liver.mean_hu, 115.0, 6.0);
}

}  // namespace
}  // namespace stylet::modeller
