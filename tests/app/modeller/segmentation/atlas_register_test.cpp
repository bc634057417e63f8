// Tests that need the registration program, which is built on ITK.
#include <gtest/gtest.h>

#include <cstdlib>

#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/atlas.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

TEST(AtlasRegistration, MapsAnotherPatientsLiverOntoTheTarget) {
    const char* bin = std::getenv("STYLET_BIN");
    AtlasSettings settings;
    settings.program = std::filesystem::path(bin ? bin : ".") / "stylet-register";
    settings.spacing_m = 0.006;
    settings.iterations = 20;
    patient::Package atlas = test::referencePatient(2, 0.0025);
    // Move the atlas to another position, as if it had another coordinate frame.
    const Vec3 moved(0.03, -0.02, 0.5);
    atlas.ct.grid.origin_m += moved;
    atlas.labels.grid.origin_m += moved;

    const patient::Package& torso = test::seededTorso();
    const AtlasPrior prior =
        alignAtlases(torso.ct, test::seededBody(), {}, {AtlasImage(atlas, settings)}, settings);
    ASSERT_EQ(prior.used, std::vector<std::string>{atlas.name});
    const Mask truth = wholeLiver(torso.labels, torso.label_table);
    const FloatVolume& liver = prior.probability[std::size_t(Organ::liver)];
    Mask found(truth.grid);
    forEachVoxel(found.grid,
                 [&](const Index3& i) { found[i] = liver.nearestOr(found.grid.centre(i), 0.0f) > 0.5f; });
    EXPECT_GT(compare(truth, found).dice, 0.88);
}

}  // namespace
}  // namespace stylet::modeller
