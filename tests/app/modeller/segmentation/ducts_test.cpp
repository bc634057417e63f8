#include "app/modeller/segmentation/ducts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/modeller/image/import_error.h"
#include "app/modeller/image/import_image.h"
#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/accuracy.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"
#include "tests/support/refused.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// Dilated ducts beside a portal branch.
Mask paintDucts(test::LiverPhantom& liver) {
    liver.tube({0.022, 0.036, 0.040}, {0.080, 0.040, 0.044}, 0.003, 160.0);
    Mask truth = liver.tube({0.016, 0.043, 0.040}, {0.082, 0.048, 0.044}, 0.0038, 5.0);
    truth = unite(truth, liver.tube({0.045, 0.045, 0.042}, {0.060, 0.075, 0.070}, 0.0022, 5.0));
    truth = unite(truth, liver.tube({0.070, 0.047, 0.043}, {0.075, 0.020, 0.066}, 0.002, 5.0));
    return unite(truth, liver.tube({0.040, 0.044, 0.041}, {0.050, 0.050, 0.018}, 0.0018, 5.0));
}

TEST(Ducts, DarkTubesAreFound) {
    test::LiverPhantom liver(96);
    const Mask truth = paintDucts(liver);
    std::string note;
    EXPECT_GT(compare(truth, findVisibleDucts(liver.ct, liver.mask, &note)).dice, 0.85);
    EXPECT_THAT(note, testing::HasSubstr("seen"));
    // Ducts that the liver mask leaves out are found too.
    EXPECT_GT(compare(truth, findVisibleDucts(liver.ct, subtract(liver.mask, truth))).dice, 0.8);

    const BuiltDucts built = buildDucts(liver.ct, liver.mask, Mask(liver.ct.grid), Mask(liver.ct.grid), true);
    EXPECT_EQ(built.origin, DuctsOrigin::visible);
    EXPECT_THAT(built.note, testing::Not(testing::HasSubstr("irtual")));
}

TEST(Ducts, TumoursAndFissuresAreExcluded) {
    test::LiverPhantom liver(96);
    liver.tube({0.030, 0.030, 0.030}, {0.0301, 0.030, 0.030}, 0.011, 40.0);  // necrosis
    liver.tube({0.060, 0.060, 0.060}, {0.0601, 0.060, 0.060}, 0.005, 5.0);   // a cyst
    for (double z = 0.010; z < 0.086; z += 0.002)                            // a fissure with fat
        liver.tube({0.048, 0.006, z}, {0.048, 0.025, z}, 0.002, -60.0);
    std::string note;
    EXPECT_EQ(countVoxels(findVisibleDucts(liver.ct, liver.mask, &note)), 0u) << note;
    EXPECT_THAT(note, testing::HasSubstr("No dilated bile ducts"));
    EXPECT_EQ(countVoxels(findVisibleDucts(liver.ct, Mask(liver.ct.grid), &note)), 0u);
    EXPECT_THAT(note, testing::HasSubstr("no liver"));
}

// As long as a fissure, and as dark and wide as dilated ducts. In a liver of half the size it could be ducts.
TEST(Ducts, ATubeThatIsShortForTheLiverIsNoDuct) {
    for (const int size : {120, 72}) {
        test::LiverPhantom liver(size);
        const double middle_m = 0.0005 * size;
        liver.tube({middle_m - 0.028, middle_m, middle_m}, {middle_m + 0.028, middle_m, middle_m}, 0.0043,
                   5.0);
        std::string note;
        const Mask ducts = findVisibleDucts(liver.ct, liver.mask, &note);
        EXPECT_EQ(countVoxels(ducts) > 0, size == 72) << note;
    }
}

// A liver full of fat is hardly brighter than bile.
TEST(Ducts, ALiverThatHidesThemIsNamed) {
    test::LiverPhantom liver(96);
    const Mask ducts = paintDucts(liver);
    for (std::size_t i = 0; i < ducts.voxels.size(); ++i)
        if (!ducts.voxels[i]) liver.ct.voxels[i] = std::int16_t(liver.ct.voxels[i] - 96);
    std::string note;
    EXPECT_EQ(countVoxels(findVisibleDucts(liver.ct, liver.mask, &note)), 0u);
    EXPECT_THAT(note, testing::HasSubstr("can be seen: the liver, of"));
}

// HZ-TEACH-09
TEST(Ducts, VirtualDuctsAreGrownOnlyOnRequestAndMarked) {
    test::LiverPhantom liver(96);
    const Mask portal = liver.tube({0.020, 0.040, 0.040}, {0.076, 0.044, 0.046}, 0.003, 160.0);
    const BuiltDucts none = buildDucts(liver.ct, liver.mask, portal, portal, false);
    EXPECT_EQ(none.origin, DuctsOrigin::none);
    EXPECT_EQ(countVoxels(none.mask), 0u);
    const BuiltDucts grown = buildDucts(liver.ct, liver.mask, portal, portal, true);
    EXPECT_EQ(grown.origin, DuctsOrigin::grown);
    EXPECT_GT(countVoxels(grown.mask), 0u);
    EXPECT_EQ(countVoxels(intersect(grown.mask, portal)), 0u);
    EXPECT_THAT(grown.note, testing::HasSubstr("irtual"));
    const auto withoutPortal = [&] {
        buildDucts(liver.ct, liver.mask, Mask(liver.ct.grid), portal, true, {.source = "a/ct.nii.gz"});
    };
    EXPECT_THAT(test::errorText<ImportError>(withoutPortal),
                testing::StartsWith("a/ct.nii.gz: voxels: no portal vein inside the liver"));
}

TEST(Ducts, MatchReferencePatient) {
    const CtVolume& ct = test::seededTorso().ct;
    const Mask inside = test::seededTruth({Id::liver, Id::ducts, Id::tumour});
    const Mask truth = test::seededTruth({Id::ducts});
    // At voxels of 2.5 mm, half of the ducts are thinner than a voxel.
    EXPECT_GT(compare(truth, findVisibleDucts(ct, closed(inside, 0.006))).dice, 0.4);
}

}  // namespace
}  // namespace stylet::modeller
