// Tests that need the registration program, which is built on ITK.
#include <gtest/gtest.h>

#include <cstdlib>

#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/atlas.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

TEST(AtlasRegistration, LaysAnotherSeedsLiverOverThisOne) {
    const char* bin = std::getenv("STYLET_BIN");
    AtlasSettings settings;
    settings.program = std::filesystem::path(bin ? bin : ".") / "stylet-register";
    settings.spacing_m = 0.006;
    settings.iterations = 20;
    patient::synth::SynthSettings other;
    other.seed = 2;
    other.spacing_m = 0.0025;
    other.defaults = test::tissueDefaults();
    patient::Package atlas = patient::synth::makeReferencePatient(other);
    // The atlas lies in another part of another coordinate frame.
    const Vec3 moved(0.03, -0.02, 0.5);
    atlas.ct.grid.origin_m += moved;
    atlas.labels.grid.origin_m += moved;

    const patient::Package& torso = test::seededTorso();
    const AtlasPrior prior =
        alignAtlases(torso.ct, test::seededBody(), {}, {AtlasImage(atlas, settings)}, settings);
    ASSERT_EQ(prior.used, std::vector<std::string>{atlas.name});
    const auto liverAt = [&](const Mask& liver, const auto& takes) {
        Mask m(liver.grid);
        for (int z = 0; z < m.grid.dims.z; ++z)
            for (int y = 0; y < m.grid.dims.y; ++y)
                for (int x = 0; x < m.grid.dims.x; ++x)
                    m[{x, y, z}] = takes(m.grid.centre({x, y, z}));
        return m;
    };
    const Mask truth = wholeLiver(torso.labels, torso.label_table);
    const FloatVolume& liver = prior.probability[std::size_t(Organ::liver)];
    const Mask laid = liverAt(truth, [&](const auto& p) { return liver.nearestOr(p, 0.0f) > 0.5f; });
    EXPECT_GT(compare(truth, laid).dice, 0.88);
}

}  // namespace
}  // namespace stylet::modeller
