#include "app/modeller/segmentation/vessels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/tubes.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// A liver with two vessel trees that touch. A hepatic vein leaves the vena cava at the back. A portal branch
// leaves the portal trunk at the front. Where the vein and the branch meet, they run side by side.
struct TwoTrees {
    test::LiverPhantom liver{64};
    Mask portal, hepatic;

    TwoTrees() {
        liver.tube({0.032, 0.012, 0.030}, {0.032, 0.012, 0.062}, 0.007, 160.0);  // cava
        hepatic = liver.tube({0.032, 0.012, 0.051}, {0.032, 0.050, 0.034}, 0.0025, 160.0);
        const Mask trunk = liver.tube({0.014, 0.040, 0.020}, {0.014, 0.030, 0.032}, 0.005, 160.0);
        const Mask branch = liver.tube({0.014, 0.034, 0.028}, {0.050, 0.033, 0.0365}, 0.0022, 160.0);
        portal = unite(trunk, branch);
    }
};

TEST(Vessels, TubesAreFoundAndBlobsAreNot) {
    test::LiverPhantom liver(56);
    Mask truth = liver.tube({0.010, 0.012, 0.012}, {0.046, 0.044, 0.040}, 0.002, 165.0);
    truth = unite(truth, liver.tube({0.028, 0.028, 0.026}, {0.028, 0.046, 0.012}, 0.0015, 165.0));
    liver.tube({0.016, 0.038, 0.040}, {0.0161, 0.038, 0.040}, 0.006, 60.0);  // a tumour
    const Mask found = findVessels(liver.ct, liver.mask).vessels;
    EXPECT_GT(compare(truth, found).dice, 0.75);
    EXPECT_LT(compare(truth, found).hausdorff_m, 0.004);
    // The same vessels are found if the surface of the liver mask is 2 mm too far out or too far in.
    EXPECT_GT(compare(truth, findVessels(liver.ct, dilated(liver.mask, 0.002)).vessels).dice, 0.70);
    EXPECT_GT(compare(truth, findVessels(liver.ct, eroded(liver.mask, 0.002)).vessels).dice, 0.70);
}

// Blood in the portal trunk is brighter in the CT than blood in most other vessels. findVessels() must place
// the wall of each vessel where the CT value is halfway between the liver and that vessel's own blood. One
// common threshold would make bright vessels too wide and dim vessels too narrow.
TEST(Vessels, BrightAndDimVesselsKeepTheirWidths) {
    test::LiverPhantom liver(72);
    const Mask bright = liver.tube({0.018, 0.018, 0.008}, {0.018, 0.022, 0.064}, 0.004, 222.0);
    Mask dim = liver.tube({0.052, 0.052, 0.008}, {0.052, 0.048, 0.064}, 0.003, 160.0);
    dim = unite(dim, liver.tube({0.054, 0.016, 0.008}, {0.048, 0.020, 0.064}, 0.003, 160.0));
    dim = unite(dim, liver.tube({0.016, 0.054, 0.008}, {0.020, 0.050, 0.064}, 0.003, 160.0));
    FloatVolume sharp(liver.ct.grid);
    std::copy(liver.ct.voxels.begin(), liver.ct.voxels.end(), sharp.voxels.begin());
    const FloatVolume blurred = gaussian(sharp, 0.0009);
    for (std::size_t i = 0; i < sharp.voxels.size(); ++i)
        liver.ct.voxels[i] = std::int16_t(std::lround(blurred.voxels[i]));
    const Mask found = findVessels(liver.ct, liver.mask).vessels;
    for (const Mask& truth : {bright, dim}) {
        const double true_ml = volume_ml(intersect(truth, liver.mask));
        const double found_ml = volume_ml(intersect(found, dilated(truth, 0.004)));

        EXPECT_NEAR(found_ml, true_ml, 0.12 * true_ml);
    }
}

// Too short to be certain, or too faint, but no planned path may cross it. What is certain is not suspected.
TEST(Vessels, AThinVeinIsSuspected) {
    for (const double thin_hu : {165.0, 136.0}) {
        SCOPED_TRACE(thin_hu);
        test::LiverPhantom liver(56);
        const Mask certain = liver.tube({0.010, 0.012, 0.012}, {0.046, 0.044, 0.040}, 0.002, 165.0);
        const Mask thin = liver.tube({0.014, 0.040, 0.036}, {0.026, 0.042, 0.040}, 0.001, thin_hu);
        const FoundVessels found = findVessels(liver.ct, liver.mask);
        EXPECT_EQ(countVoxels(intersect(found.vessels, thin)), 0u);
        EXPECT_GT(double(countVoxels(intersect(found.suspected, thin))), 0.6 * double(countVoxels(thin)));
        EXPECT_EQ(countVoxels(intersect(found.suspected, found.vessels)), 0u);
        EXPECT_EQ(countVoxels(subtract(found.suspected, liver.mask)), 0u);
        // Few voxels are suspected by chance.
        const Mask beside = subtract(found.suspected, dilated(unite(certain, thin), 0.003));
        EXPECT_LT(double(countVoxels(beside)), 0.002 * double(countVoxels(liver.mask)));
    }
}

TEST(Vessels, WithoutContrastOrLiverNoVesselsAreFound) {
    const test::LiverPhantom liver(40);
    const FoundVessels in_liver = findVessels(liver.ct, liver.mask);
    const Mask& found = in_liver.vessels;
    EXPECT_EQ(countVoxels(found), 0u);
    EXPECT_EQ(countVoxels(in_liver.suspected), 0u);
    EXPECT_EQ(countVoxels(findVessels(liver.ct, Mask(liver.ct.grid)).vessels), 0u);
    const SplitVessels split = splitVessels(liver.ct, liver.mask, found);
    EXPECT_EQ(countVoxels(split.portal) + countVoxels(split.hepatic), 0u);
    ASSERT_EQ(split.notes.size(), 1u);
    EXPECT_THAT(split.notes[0], testing::HasSubstr("contrast"));
}

TEST(Vessels, TouchingTreesAreSeparated) {
    const TwoTrees t;
    const Mask vessels = intersect(unite(t.portal, t.hepatic), t.liver.mask);
    const SplitVessels split = splitVessels(t.liver.ct, t.liver.mask, vessels);
    EXPECT_GT(countVoxels(split.cava), 0u);
    EXPECT_EQ(countVoxels(split.portal) + countVoxels(split.hepatic), countVoxels(vessels));
    EXPECT_EQ(countVoxels(intersect(split.portal, split.hepatic)), 0u);
    EXPECT_GT(compare(intersect(subtract(t.portal, t.hepatic), t.liver.mask), split.portal).dice, 0.85);
    EXPECT_GT(compare(intersect(subtract(t.hepatic, t.portal), t.liver.mask), split.hepatic).dice, 0.80);
}

// A hepatic vein passes through the liver and touches a portal branch close to the portal trunk, far from the
// vena cava. Below the contact it is still a hepatic vein, although the portal trunk is nearer.
TEST(Vessels, AVeinThatTouchesThePortalVeinKeepsItsFarEnd) {
    test::LiverPhantom liver(84);
    liver.tube({0.042, 0.014, 0.044}, {0.042, 0.014, 0.080}, 0.008, 160.0);  // cava
    const Mask stem = liver.tube({0.042, 0.014, 0.068}, {0.060, 0.044, 0.040}, 0.0028, 160.0);
    const Mask far = liver.tube({0.060, 0.044, 0.040}, {0.060, 0.066, 0.012}, 0.0022, 160.0);
    const Mask trunk = liver.tube({0.030, 0.050, 0.018}, {0.030, 0.044, 0.036}, 0.005, 160.0);
    const Mask branch = liver.tube({0.030, 0.046, 0.0312}, {0.074, 0.0452, 0.0306}, 0.0026, 160.0);
    const Mask hepatic = intersect(unite(stem, far), liver.mask);
    const Mask portal = subtract(intersect(unite(trunk, branch), liver.mask), hepatic);

    const SplitVessels split = splitVessels(liver.ct, liver.mask, unite(portal, hepatic));
    EXPECT_GT(compare(hepatic, split.hepatic).dice, 0.9);
    EXPECT_GT(compare(portal, split.portal).dice, 0.9);
    const Mask end = intersect(subtract(far, dilated(branch, 0.003)), liver.mask);
    EXPECT_GT(double(countVoxels(intersect(end, split.hepatic))), 0.95 * double(countVoxels(end)));
}

// The upper end of a wide hepatic vein was not found, and a thin portal branch crosses it. Its only
// connection leads to the portal trunk, but it runs towards the vena cava and is wider than the branch.
TEST(Vessels, AVeinWithoutItsStemIsKnownByItsCourse) {
    test::LiverPhantom liver(84);
    liver.tube({0.042, 0.014, 0.044}, {0.042, 0.014, 0.080}, 0.008, 160.0);  // cava
    const Mask other = liver.tube({0.042, 0.014, 0.068}, {0.020, 0.050, 0.060}, 0.0025, 160.0);
    const Mask vein = liver.tube({0.042, 0.030, 0.056}, {0.060, 0.070, 0.012}, 0.0028, 160.0);
    const Mask trunk = liver.tube({0.030, 0.050, 0.018}, {0.030, 0.044, 0.036}, 0.005, 160.0);
    const Mask branch = liver.tube({0.030, 0.046, 0.0312}, {0.074, 0.0515, 0.0335}, 0.0016, 160.0);
    const Mask hepatic = intersect(unite(other, vein), liver.mask);
    const Mask portal = subtract(intersect(unite(trunk, branch), liver.mask), hepatic);

    const SplitVessels split = splitVessels(liver.ct, liver.mask, unite(portal, hepatic));
    EXPECT_GT(compare(hepatic, split.hepatic).dice, 0.9);
    EXPECT_GT(compare(portal, split.portal).dice, 0.9);
}

// A slice of the vein is as dark as the liver. The rest of the vein is still connected to the vena cava.
TEST(Vessels, ADarkSliceDoesNotDivideAVein) {
    test::LiverPhantom liver(72);
    liver.tube({0.036, 0.014, 0.030}, {0.036, 0.014, 0.070}, 0.008, 160.0);  // cava
    const Mask stem = liver.tube({0.036, 0.014, 0.060}, {0.036, 0.056, 0.046}, 0.0025, 160.0);
    const Mask trunk = liver.tube({0.018, 0.040, 0.020}, {0.018, 0.036, 0.036}, 0.005, 160.0);
    for (std::size_t i = 0; i < liver.ct.voxels.size(); ++i)
        if (stem.voxels[i] && liver.ct.grid.voxelAt(i).y == 34) liver.ct.voxels[i] = 90;
    const Mask hepatic = intersect(stem, liver.mask), portal = intersect(trunk, liver.mask);
    const SplitVessels split = splitVessels(liver.ct, liver.mask, unite(portal, hepatic));
    EXPECT_EQ(countVoxels(intersect(hepatic, split.portal)), 0u);
    EXPECT_EQ(countVoxels(intersect(portal, split.hepatic)), 0u);
}

// A hepatic and a portal vein run side by side. Their contact is larger than a cross-section of either, but
// the wall in it is darker than blood.
TEST(Vessels, ADarkWallSeparatesVeinsThatRunSideBySide) {
    test::LiverPhantom liver(84);
    liver.tube({0.042, 0.014, 0.044}, {0.042, 0.014, 0.080}, 0.008, 160.0);  // cava
    const Mask vein = unite(liver.tube({0.042, 0.014, 0.066}, {0.042, 0.034, 0.046}, 0.0025, 160.0),
                            liver.tube({0.042, 0.034, 0.046}, {0.042, 0.060, 0.046}, 0.0025, 160.0));
    const Mask trunk = liver.tube({0.030, 0.050, 0.018}, {0.030, 0.044, 0.038}, 0.005, 160.0);
    const Mask branch = unite(liver.tube({0.030, 0.046, 0.036}, {0.0375, 0.038, 0.046}, 0.0026, 160.0),
                              liver.tube({0.0375, 0.038, 0.046}, {0.0375, 0.060, 0.046}, 0.0022, 160.0));
    forEachVoxel(liver.ct.grid, [&](const Index3& i) {  // the wall, one voxel thick
        if (i.x == 40 && i.y > 35 && (vein[i] || branch[i])) liver.ct[i] = 135;
    });
    const Mask hepatic = intersect(vein, liver.mask);
    const Mask portal = subtract(intersect(unite(trunk, branch), liver.mask), vein);
    const SplitVessels split = splitVessels(liver.ct, liver.mask, unite(portal, hepatic));
    EXPECT_GT(compare(hepatic, split.hepatic).dice, 0.9);
    EXPECT_GT(compare(portal, split.portal).dice, 0.9);
}

// The portal trunk is too thin to be found. Its tree is still found, from its widest branch.
TEST(Vessels, ATreeWithoutATrunkKeepsItsBranches) {
    test::LiverPhantom liver(64);
    liver.tube({0.032, 0.012, 0.030}, {0.032, 0.012, 0.062}, 0.007, 160.0);  // cava
    const Mask stem = liver.tube({0.032, 0.012, 0.051}, {0.032, 0.050, 0.034}, 0.0025, 160.0);
    const Mask branch = liver.tube({0.010, 0.0325, 0.0325}, {0.054, 0.0315, 0.040}, 0.0028, 160.0);
    const Mask hepatic = intersect(stem, liver.mask);
    const Mask portal = subtract(intersect(branch, liver.mask), hepatic);
    const SplitVessels split = splitVessels(liver.ct, liver.mask, unite(portal, hepatic));
    ASSERT_FALSE(split.notes.empty());
    EXPECT_THAT(split.notes[0], testing::HasSubstr("No portal trunk"));
    EXPECT_GT(compare(hepatic, split.hepatic).dice, 0.8);
    EXPECT_GT(compare(portal, split.portal).dice, 0.8);
}

// The portal trunk forks into two branches, and it touches the vena cava at this fork. The liver mask ends
// before the fork, so nothing inside the liver connects the two branches. In addition, the end of a hepatic
// vein touches one of the branches. Both branches must still be labelled as portal vein.
TEST(Vessels, PortalTrunkTouchingTheCavaIsFound) {
    test::LiverPhantom liver(72);
    const Mask cava = liver.tube({0.036, 0.014, 0.008}, {0.036, 0.014, 0.070}, 0.008, 160.0);
    const Mask trunk = liver.tube({0.036, 0.028, 0.020}, {0.036, 0.026, 0.036}, 0.0045, 160.0);
    const Mask left = liver.tube({0.036, 0.027, 0.034}, {0.018, 0.032, 0.034}, 0.004, 160.0);
    const Mask right = liver.tube({0.036, 0.027, 0.034}, {0.062, 0.032, 0.034}, 0.0048, 160.0);
    const Mask leaf = liver.tube({0.018, 0.032, 0.034}, {0.014, 0.052, 0.030}, 0.0022, 160.0);
    const Mask stem = liver.tube({0.036, 0.014, 0.060}, {0.014, 0.042, 0.052}, 0.0025, 160.0);
    const Mask vein = unite(stem, liver.tube({0.014, 0.042, 0.052}, {0.014, 0.054, 0.034}, 0.0022, 160.0));
    const Mask within = subtract(liver.mask, dilated(unite(trunk, cava), 0.003));
    const Mask portal = intersect(unite(unite(left, right), leaf), within);
    const Mask hepatic = subtract(intersect(vein, within), portal);

    const SplitVessels split = splitVessels(liver.ct, within, unite(portal, hepatic));
    EXPECT_GT(compare(portal, split.portal).dice, 0.90);
    EXPECT_GT(compare(hepatic, split.hepatic).dice, 0.85);
    // Below the fork, at most the rim of the trunk may be labelled as vena cava.
    const Mask below = subtract(trunk, dilated(unite(left, right), 0.002));
    EXPECT_LT(double(countVoxels(intersect(below, split.cava))), 0.2 * double(countVoxels(below)));
}

TEST(Vessels, WithoutCavaTheWidestVesselIsTheSeed) {
    test::LiverPhantom liver(56);
    const Mask vessels =
        intersect(liver.tube({0.020, 0.028, 0.010}, {0.020, 0.028, 0.046}, 0.002, 165.0), liver.mask);
    const SplitVessels split = splitVessels(liver.ct, liver.mask, vessels);
    EXPECT_EQ(countVoxels(split.portal) + countVoxels(split.hepatic), countVoxels(vessels));
    EXPECT_FALSE(split.notes.empty());
}

TEST(Vessels, MatchReferencePatient) {
    const CtVolume& ct = test::seededTorso().ct;
    const Mask inside = test::seededTruth({Id::liver, Id::ducts, Id::tumour});
    const Mask truth = test::seededTruth({Id::portal, Id::hepaticVeins});
    const Mask liver = unite(inside, intersect(truth, closed(inside, 0.006)));
    const Mask vessels = findVessels(ct, liver).vessels;
    EXPECT_GT(compare(intersect(truth, liver), vessels).dice, 0.55);
    const SplitVessels split = splitVessels(ct, liver, vessels);
    const Mask portal = intersect(test::seededTruth({Id::portal}), vessels);
    const Mask hepatic = intersect(test::seededTruth({Id::hepaticVeins}), vessels);
    EXPECT_GT(double(countVoxels(intersect(portal, split.portal))), 0.9 * double(countVoxels(portal)));
    EXPECT_GT(double(countVoxels(intersect(hepatic, split.hepatic))), 0.9 * double(countVoxels(hepatic)));
}

}  // namespace
}  // namespace stylet::modeller
