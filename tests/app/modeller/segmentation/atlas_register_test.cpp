// Tests that need the registration program, which is built on ITK.
#include <gtest/gtest.h>

#include <cstdlib>

#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/atlas.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

// Registers another patient, scaled and moved, its liver brighter by `brighter_hu`. Returns the Dice of the
// liver that it expects.
double diceOfPriorLiver(double size, const Vec3& moved, int brighter_hu = 0) {
    const char* bin = std::getenv("STYLET_BIN");
    AtlasSettings settings;
    settings.program = std::filesystem::path(bin ? bin : ".") / "stylet-register";
    settings.spacing_m = 0.006;
    settings.iterations = 20;
    patient::Package atlas = test::referencePatient(2, 0.0025);
    for (Grid* g : {&atlas.ct.grid, &atlas.labels.grid}) {
        g->spacing_m *= size;
        g->origin_m = size * g->origin_m + moved;
    }
    const Mask atlas_liver = wholeLiver(atlas.labels, atlas.label_table);
    for (std::size_t i = 0; i < atlas_liver.voxels.size(); ++i)
        if (atlas_liver.voxels[i]) atlas.ct.voxels[i] = std::int16_t(atlas.ct.voxels[i] + brighter_hu);
    const patient::Package& torso = test::seededTorso();
    const AtlasPrior prior =
        alignAtlases(torso.ct, test::seededBody(), {}, {AtlasImage(atlas, settings)}, settings);
    EXPECT_EQ(prior.used, std::vector<std::string>{atlas.name});
    const Mask truth = wholeLiver(torso.labels, torso.label_table);
    const FloatVolume& liver = prior.probability[std::size_t(Organ::liver)];
    Mask found(truth.grid);
    forEachVoxel(found.grid,
                 [&](const Index3& i) { found[i] = liver.nearestOr(found.grid.centre(i), 0.0f) > 0.5f; });
    return compare(truth, found).dice;
}

TEST(AtlasRegistration, MapsAnotherPatientsLiverOntoTheTarget) {
    // In another position, as if in another coordinate frame.
    EXPECT_GT(diceOfPriorLiver(1.0, Vec3(0.03, -0.02, 0.5)), 0.88);
}

TEST(AtlasRegistration, ThePatientsMayDifferInSize) {
    for (const double size : {0.8, 1.15, 1.35})
        EXPECT_GT(diceOfPriorLiver(size, Vec3(0.0)), 0.85) << "other patient's size " << size;
}

TEST(AtlasRegistration, TheLiversMayDifferInBrightness) {
    for (const int brighter_hu : {-70, 50})
        EXPECT_GT(diceOfPriorLiver(1.0, Vec3(0.0), brighter_hu), 0.88) << brighter_hu << " HU brighter";
}

}  // namespace
}  // namespace stylet::modeller
