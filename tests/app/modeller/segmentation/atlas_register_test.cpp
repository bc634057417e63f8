// Tests that need the registration program, which is built on ITK.
#include <gtest/gtest.h>

#include <cstdlib>

#include "app/modeller/image/handover_files.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/atlas.h"
#include "base/text.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

std::filesystem::path registerProgram() {
    const char* bin = std::getenv("STYLET_BIN");
    return std::filesystem::path(bin ? bin : ".") / "stylet-register";
}

// Registers another patient, scaled and moved, its liver brighter by `brighter_hu`, without the shares `low`
// and `high` of its height at the ends. Returns the Dice of the liver that it expects.
double diceOfPriorLiver(double size, const Vec3& moved, int brighter_hu = 0, double low = 0.0,
                        double high = 0.0) {
    AtlasSettings settings;
    settings.program = registerProgram();
    settings.spacing_m = 0.006;
    settings.iterations = 20;
    patient::Package atlas = test::stillPatient(2, 0.0025);
    for (Grid* g : {&atlas.ct.grid, &atlas.labels.grid}) {
        g->spacing_m *= size;
        g->origin_m = size * g->origin_m + moved;
    }
    const Index3 last = atlas.ct.grid.dims - 1;
    const VoxelBox section{{0, 0, int(low * last.z)}, {last.x, last.y, int((1.0 - high) * last.z)}};
    atlas.ct = cropped(atlas.ct, section), atlas.labels = cropped(atlas.labels, section);
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

TEST(AtlasRegistration, TheScanMayBeTallerThanTheAtlas) {
    for (const auto& [low, high] : {std::pair(0.0, 0.25), {0.25, 0.0}, {0.15, 0.15}}) {
        const double dice = diceOfPriorLiver(1.0, Vec3(0.0), 0, low, high);
        EXPECT_GT(dice, 0.8) << low << ", " << high;
    }
}

// Two images of a round body with two small organs. In the first, the upper third is bright and unlike the
// second. If only the overlap counted, the second would be moved out of that third.
TEST(AtlasRegistration, AnUnlikeEndIsNotLeftOutside) {
    constexpr double kUnlike_mm = 160.0;
    Volume<std::int16_t> fixed({Index3(40, 40, 30), Vec3(0.008), Vec3(0.0)}, -300);
    forEachVoxel(fixed.grid, [&](const Index3& i) {
        const Vec3 p = 1e3 * fixed.grid.centre(i);
        if (std::hypot(p.x - 156.0, p.y - 156.0) > 120.0) return;
        fixed[i] = glm::length(p - Vec3(110, 150, 70)) < 30.0    ? 110
                   : glm::length(p - Vec3(200, 170, 110)) < 25.0 ? -100
                                                                 : 40;
    });
    const Volume<std::int16_t> moving = fixed;
    forEachVoxel(fixed.grid, [&](const Index3& i) {
        if (fixed[i] > -300 && 1e3 * fixed.grid.centre(i).z > kUnlike_mm) fixed[i] = 220;
    });
    const PrivateFolder folder;
    const std::filesystem::path f = folder.path() / "f", m = folder.path() / "m", out = folder.path() / "out";
    writeImageFile(f, fixed);
    writeImageFile(m, moving);
    runChild(registerProgram(), {"affine", f, m, out, shortestText(AtlasSettings{}.affine_share)}, {},
             "the phantom", "the registration");
    const Vec3 ball(0.110, 0.150, 0.070);
    EXPECT_LT(glm::length(readAffineFile(out)(ball) - ball), 0.020);
}

}  // namespace
}  // namespace stylet::modeller
