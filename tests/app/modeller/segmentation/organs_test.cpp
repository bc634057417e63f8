#include "app/modeller/segmentation/organs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "app/modeller/import/import_map.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/wall/fascia_spline.h"
#include "tests/app/modeller/segmentation/liver_phantom.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"

namespace stylet::modeller {
namespace {

using patient::synth::Id;

// A box of fat, 240 x 180 x 160 mm. Tests add structures. The spinal canal runs at x = 0, y = 0.
struct OrganPhantom {
    CtVolume ct;
    Mask body, inside, liver, portal;
    Lungs lungs;
    Bones bones;

    explicit OrganPhantom(double spacing_m = 0.003) {
        const Grid g{Index3(Vec3(0.240, 0.180, 0.162) / spacing_m + 0.5), Vec3(spacing_m),
                     Vec3(-0.12, -0.03, 0.0)};
        ct = CtVolume(g, -100);
        body = inside = Mask(g, 1);
        for (int z = 0; z < g.dims.z; ++z)
            for (int y = 0; y < g.dims.y; ++y)
                for (const int x : {0, 1, g.dims.x - 2, g.dims.x - 1})
                    inside[{x, y, z}] = 0;
        liver = portal = Mask(g);
        lungs = {Mask(g), Mask(g), Mask(g), Mask(g), {}, {}, {}};
        for (Mask* m : {&bones.all, &bones.canal, &bones.cartilage})
            *m = Mask(g);
        for (int z = 0; z < g.dims.z; ++z)
            bones.canal_m.push_back({0.0, 0.0, g.centre({0, 0, z}).z});
    }
    Mask ball(const Vec3& middle, double radius_m, std::int16_t hu) {
        Mask m(ct.grid);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const Vec3 d = ct.grid.centre(i) - middle;
            if (glm::dot(d, d) < radius_m * radius_m) m[i] = 1, ct[i] = hu;
        });
        return m;
    }
    Mask tube(double x_m, double y_m, double radius_m, std::int16_t hu) {
        Mask m(ct.grid);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            const Vec3 p = ct.grid.centre(i);
            if (std::hypot(p.x - x_m, p.y - y_m) < radius_m) m[i] = 1, ct[i] = hu;
        });
        return m;
    }
    // A tube along straight lines from point to point.
    Mask bentTube(const std::vector<Vec3>& points, double radius_m, std::int16_t hu) {
        Mask m(ct.grid);
        forEachVoxel(ct.grid, [&](const Index3& i) {
            for (std::size_t n = 1; n < points.size(); ++n)
                if (test::toSegment_m(ct.grid.centre(i), points[n - 1], points[n]) < radius_m)
                    m[i] = 1, ct[i] = hu;
        });
        return m;
    }
    // Uniform values of this standard deviation.
    void addNoise(double sigma_hu, unsigned seed = 7) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> share(-1.0, 1.0);
        for (std::int16_t& hu : ct.voxels)
            hu = std::int16_t(hu + std::sqrt(3.0) * sigma_hu * share(random));
    }
    std::map<std::string, FoundOrgan> organs() const {
        std::map<std::string, FoundOrgan> out;
        for (FoundOrgan& o : findOrgans({ct, body, lungs, bones, liver, portal, inside}))
            out[o.name] = std::move(o);
        return out;
    }
};

TEST(Organs, BallsAndTubesAtOrganPositionsAreFound) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    const Mask right = b.ball({0.055, 0.02, 0.030}, 0.027, 190),
               left = b.ball({-0.055, 0.02, 0.06}, 0.027, 190);
    const Mask spleen = b.ball({-0.08, 0.04, 0.115}, 0.028, 118);
    const Mask aorta = b.tube(-0.012, 0.048, 0.010, 175), cava = b.tube(0.018, 0.055, 0.009, 150);
    const auto found = b.organs();
    ASSERT_EQ(found.size(), 12u);
    EXPECT_GT(compare(right, found.at("right kidney").mask).dice, 0.9);
    EXPECT_GT(compare(left, found.at("left kidney").mask).dice, 0.9);
    EXPECT_GT(compare(spleen, found.at("spleen").mask).dice, 0.9);
    EXPECT_GT(compare(aorta, found.at("aorta and arteries").mask).dice, 0.85);
    EXPECT_GT(compare(subtract(cava, b.liver), found.at("vena cava and renal veins").mask).dice, 0.8);
    for (const auto& [name, organ] : found) {
        EXPECT_NE(findTarget(name), nullptr) << name;
        EXPECT_EQ(organ.confidence > 0.0, countVoxels(organ.mask) > 0) << name;
        EXPECT_LE(organ.confidence, 1.0);
    }
}

// The first fascia, on which the search for organs is based, runs through the aorta.
TEST(Organs, TheFirstFasciaDoesNotCutTheAorta) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    const Mask aorta = b.tube(-0.012, 0.048, 0.010, 175);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        const Vec3 p = b.ct.grid.centre(i);
        if (p.x < -0.012 && p.y < 0.060) b.inside[i] = 0;
    });
    EXPECT_GT(compare(aorta, b.organs().at("aorta and arteries").mask).dice, 0.85);
}

// The aorta ends above the scan's lower end, as at its fork. Below, only the cava is wide enough for either
// vessel, and it must not be taken for the aorta. A cava without medium is not found, and the aorta must not
// be taken for it: neither if the aorta is near the midline, nor if a bowel loop could be the aorta instead.
TEST(Organs, TheCavaBesideTheForkOfTheAortaIsNotAorta) {
    struct Case {
        std::int16_t cava_hu;
        double aorta_x_m, lowest_m;
        bool loop;
    };
    for (const auto& [cava_hu, aorta_x_m, lowest_m, loop] :
         {Case{150, -0.010, 0.06, false}, Case{45, -0.010, 0.06, false}, Case{45, 0.010, 0.0, false},
          Case{45, -0.010, 0.0, true}}) {
        SCOPED_TRACE(testing::Message() << cava_hu << " HU, aorta at " << aorta_x_m << ", loop " << loop);
        OrganPhantom b;
        b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
        const Mask cava = b.tube(aorta_x_m + 0.024, 0.046, 0.009, cava_hu);
        if (loop) b.tube(aorta_x_m - 0.025, 0.046, 0.008, 175);
        Mask aorta(b.ct.grid);
        forEachVoxel(b.ct.grid, [&](const Index3& i) {
            const Vec3 p = b.ct.grid.centre(i);
            if (p.z > lowest_m && std::hypot(p.x - aorta_x_m, p.y - 0.046) < 0.009)
                aorta[i] = 1, b.ct[i] = 175;
        });
        const auto found = b.organs();
        EXPECT_GT(compare(aorta, found.at("aorta and arteries").mask).dice, 0.95);
        const Mask& found_cava = found.at("vena cava and renal veins").mask;
        if (cava_hu > 100) {
            EXPECT_GT(compare(subtract(cava, b.liver), found_cava).dice, 0.95);
        } else {
            EXPECT_EQ(countVoxels(found_cava), 0u);
        }
    }
}

// The left renal vein passes in front of the aorta. There it touches the splenic vein, which is wider, a part
// of the portal vein, and passes the upper pole of the kidney. A loop of the duodenum, full of medium, lies
// between the cava and the right kidney.
TEST(Organs, RenalVeinsJoinTheCavaAndNotThePortalVein) {
    OrganPhantom b(0.002);
    b.liver = b.ball({0.07, 0.06, 0.11}, 0.045, 110);
    b.tube(-0.012, 0.038, 0.010, 175);
    const Mask cava = b.tube(0.022, 0.045, 0.009, 150);
    const Mask vein_left =
        b.bentTube({{0.022, 0.05, 0.06}, {-0.012, 0.056, 0.06}, {-0.03, 0.045, 0.06}, {-0.045, 0.022, 0.06}},
                   0.0035, 165);
    const Mask vein_right = b.bentTube({{0.022, 0.04, 0.045}, {0.05, 0.015, 0.035}}, 0.0035, 165);
    const Mask splenic = b.bentTube(
        {{0.05, 0.08, 0.125}, {0.02, 0.1, 0.11}, {-0.012, 0.0645, 0.065}, {-0.06, 0.045, 0.085}}, 0.005, 175);
    const Mask loop = b.bentTube({{0.028, 0.05, 0.03}, {0.058, 0.04, 0.035}}, 0.006, 300);
    const Mask left = b.ball({-0.060, 0.02, 0.06}, 0.027, 190),
               right = b.ball({0.068, 0.015, 0.035}, 0.027, 190);
    b.portal = intersect(splenic, b.liver);
    const Mask kidneys = unite(left, right);
    const auto share = [](const Mask& of, const Mask& in) {
        return double(countVoxels(intersect(of, in))) / double(countVoxels(of));
    };
    const Mask outside = subtract(splenic, unite(b.liver, kidneys));
    {
        const auto found = b.organs();
        const Mask &found_cava = found.at("vena cava and renal veins").mask,
                   &portal = found.at("portal vein").mask;
        for (const Mask& vein : {vein_left, vein_right}) {
            const Mask renal = subtract(subtract(vein, splenic), unite(unite(cava, kidneys), b.liver));
            EXPECT_GT(share(renal, found_cava), 0.7);
            EXPECT_LT(share(renal, portal), 0.1);
        }
        EXPECT_LT(share(outside, found_cava), 0.05);
        EXPECT_GT(share(outside, portal), 0.6);
        EXPECT_LT(share(subtract(loop, dilated(cava, 0.005)), found_cava), 0.1);
    }
    // Veins without medium do not show, and nothing else is taken for them.
    const Mask veins = unite(vein_left, vein_right);
    for (std::size_t i = 0; i < b.ct.voxels.size(); ++i)
        if (veins.voxels[i] && !cava.voxels[i] && !splenic.voxels[i] && !kidneys.voxels[i])
            b.ct.voxels[i] = 45;
    const auto dark = b.organs();
    EXPECT_EQ(countVoxels(subtract(dark.at("vena cava and renal veins").mask, dilated(cava, 0.005))), 0u);
}

// The trunk leaves the liver towards a bowel loop that is full of contrast medium.
TEST(Organs, ThePortalTrunkIsGrownFromTheVeinInTheLiver) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    const Mask loop = b.ball({-0.045, 0.09, 0.10}, 0.020, 175);
    Mask vein(b.ct.grid);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        const Vec3 p = b.ct.grid.centre(i);
        vein[i] = p.x > -0.03 && p.x < 0.07 && std::hypot(p.y - 0.085, p.z - 0.10) < 0.006;
        if (vein[i]) b.ct[i] = 175;
    });
    EXPECT_EQ(countVoxels(b.organs().at("portal vein").mask), 0u);  // none is known in the liver
    b.portal = intersect(vein, b.liver);
    const Mask trunk = b.organs().at("portal vein").mask;
    EXPECT_GT(compare(subtract(subtract(vein, b.liver), loop), trunk).dice, 0.8);
    EXPECT_LT(volume_ml(intersect(trunk, loop)), 0.05 * volume_ml(loop));
}

// The vein leaves the liver 0.085 m from its far end.
TEST(Organs, ThePortalTrunkIsFollowedBeyondSixCentimetres) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    Mask vein(b.ct.grid);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        const Vec3 p = b.ct.grid.centre(i);
        vein[i] = p.x > -0.06 && p.x < 0.07 && std::hypot(p.y - 0.085, p.z - 0.10) < 0.006;
        if (vein[i]) b.ct[i] = 175;
    });
    b.portal = intersect(vein, b.liver);
    EXPECT_GT(compare(subtract(vein, b.liver), b.organs().at("portal vein").mask).dice, 0.9);
}

// Noise was taken for a vein, or blood has no contrast: soft tissue outside is as bright.
TEST(Organs, AVeinAsBrightAsTheLiverHasNoTrunk) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        const Vec3 p = b.ct.grid.centre(i);
        if (p.x > -0.03 && p.x < 0.07 && std::hypot(p.y - 0.085, p.z - 0.10) < 0.006)
            b.ct[i] = 112, b.portal[i] = b.liver[i];
    });
    ASSERT_GT(volume_ml(b.portal), 1.0);
    const FoundOrgan trunk = b.organs().at("portal vein");
    EXPECT_EQ(countVoxels(trunk.mask), 0u);
    EXPECT_NE(trunk.note.find("not seen"), std::string::npos) << trunk.note;
}

// The spleen is so much denser than this liver that it would be taken for a kidney.
TEST(Organs, AFattyLiverIsNoMeasureOfTheSpleen) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 60);
    const Mask left = b.ball({-0.055, 0.02, 0.055}, 0.027, 190);
    const Mask spleen = b.ball({-0.08, 0.04, 0.110}, 0.029, 118);
    const auto found = b.organs();
    EXPECT_GT(compare(left, found.at("left kidney").mask).dice, 0.9);
    EXPECT_GT(compare(spleen, found.at("spleen").mask).dice, 0.9);
}

TEST(Organs, NoiseTearsNoHolesIntoTheSpleen) {
    OrganPhantom b(0.0014);
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 110);
    const Mask spleen = b.ball({-0.08, 0.04, 0.110}, 0.029, 118);
    b.addNoise(75.0);
    EXPECT_GT(compare(spleen, b.organs().at("spleen").mask).dice, 0.85);
}

// The bowel's value is taken for the spleen's, and the kidney is not denser.
TEST(Organs, MediumInTheBowelDoesNotHideAKidney) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 105);
    const Mask left = b.ball({-0.055, 0.02, 0.055}, 0.027, 165);
    b.ball({-0.08, 0.04, 0.110}, 0.022, 150);
    EXPECT_GT(compare(left, b.organs().at("left kidney").mask).dice, 0.9);
}

TEST(Organs, ANecroticTumourIsNoGallbladder) {
    OrganPhantom b;
    b.liver = b.ball({0.06, 0.06, 0.10}, 0.048, 110);
    const Mask necrosis = b.ball({0.06, 0.06, 0.10}, 0.020, 20),
               pouch = b.ball({0.05, 0.075, 0.046}, 0.015, 12);
    b.liver = subtract(b.liver, unite(necrosis, pouch));
    EXPECT_GT(compare(pouch, b.organs().at("gallbladder").mask).dice, 0.85);
}

TEST(Organs, WithoutContrastMediumNoOrganIsFound) {
    OrganPhantom b;
    b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 55);
    b.ball({0.055, 0.02, 0.030}, 0.027, 32);
    b.tube(-0.012, 0.048, 0.010, 42);
    for (const auto& [name, organ] : b.organs()) {
        if (name == "gallbladder") continue;  // dark with and without contrast
        EXPECT_EQ(countVoxels(organ.mask), 0u) << name;
        EXPECT_EQ(organ.confidence, 0.0) << name;
        EXPECT_FALSE(organ.note.empty()) << name;
    }
}

class Stomach : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Liver, Stomach, testing::Bool(), [](const testing::TestParamInfo<bool>& fatty) {
    return fatty.param ? "fatty" : "unknown";
});

// The contents are as dense as a fatty liver and darker than its spleen.
TEST_P(Stomach, IsGasOverAFluidLevel) {
    OrganPhantom b;
    if (GetParam()) {
        b.liver = b.ball({0.07, 0.06, 0.10}, 0.045, 60);
        b.ball({-0.08, 0.02, 0.110}, 0.029, 118);
    }
    const Vec3 middle{-0.04, 0.08, 0.09};
    const Mask all = b.ball(middle, 0.032, GetParam() ? 55 : 30);
    Mask fluid(b.ct.grid);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        if (!all[i]) return;
        if (b.ct.grid.centre(i).y > 0.08) {
            b.ct[i] = -1000;
            b.lungs.gas[i] = 1;
        } else {
            fluid[i] = 1;
        }
    });
    const auto found = b.organs();
    const Mask& stomach = found.at("stomach and oesophagus").mask;
    EXPECT_GT(countVoxels(intersect(stomach, fluid)), countVoxels(fluid) * 9 / 10);
    EXPECT_EQ(found.at("bowel gas").mask.voxels, b.lungs.gas.voxels);
    EXPECT_EQ(countVoxels(found.at("colon").mask), 0u);
}

// Every stage must finish on any scan and explain its result.
TEST(Organs, OddScansGiveEmptyMasks) {
    for (const Index3& dims : {Index3(1), Index3(3, 5, 2), Index3(9, 7, 30)})
        for (const std::int16_t hu : {-1024, 40, 3000}) {
            const CtVolume ct({dims, Vec3(0.003), Vec3(0.0)}, hu);
            for (const Mask& body : {Mask(ct.grid), Mask(ct.grid, 1)}) {
                const Lungs lungs = findLungs(ct, body);
                const Bones bones = findBones(ct, body, {});
                const Mask none(ct.grid);
                const FasciaInput in{ct, body, bones.all, none};
                const FasciaSpline fascia = fitFascia(in);
                const Mask inside = insideFascia(fascia, in);
                EXPECT_EQ(parseFascia("f", writeFascia(fascia)).levels, fascia.levels);
                EXPECT_EQ(findOrgans({ct, body, lungs, bones, none, none, inside}).size(), 12u);
            }
        }
}

TEST(Organs, BubblesOverTheSameFluidAreOneStomach) {
    OrganPhantom b;
    const Mask all = b.ball({-0.04, 0.08, 0.09}, 0.038, 30);
    Mask far_gas(b.ct.grid);
    forEachVoxel(b.ct.grid, [&](const Index3& i) {
        const Vec3 p = b.ct.grid.centre(i);
        if (!all[i] || p.y < 0.085 || std::fabs(p.x + 0.03) < 0.004) return;
        b.ct[i] = -1000;
        b.lungs.gas[i] = 1;
        far_gas[i] = p.x > -0.03;  // the smaller bubble
    });
    const auto found = b.organs();
    const Mask wall = subtract(dilated(far_gas, 0.003), b.lungs.gas);
    EXPECT_GT(countVoxels(intersect(wall, found.at("stomach and oesophagus").mask)),
              countVoxels(wall) * 8 / 10);
    EXPECT_EQ(countVoxels(found.at("colon").mask), 0u);
}

// Stool in the left flank, and a loop of the small bowel with contents of the same mean value.
TEST(Organs, UnevenContentsAreStoolAndNoiseIsNot) {
    for (const double noise_hu : {0.0, 30.0}) {
        OrganPhantom b(0.0014);
        b.liver = b.ball({0.07, 0.06, 0.115}, 0.040, 110);
        const Mask colon = b.tube(-0.06, 0.07, 0.022, 0), loop = b.tube(0.03, 0.09, 0.016, 0);
        OrganPhantom patches;
        patches.ct = CtVolume(b.ct.grid, 0);
        patches.addNoise(150.0, 8);  // 14 HU after smoothing
        for (std::size_t i = 0; i < colon.voxels.size(); ++i)
            if (colon.voxels[i]) b.ct.voxels[i] = patches.ct.voxels[i];
        b.addNoise(noise_hu);
        const auto found = b.organs();
        EXPECT_GT(compare(colon, found.at("colon").mask).dice, 0.8) << noise_hu;
        EXPECT_EQ(countVoxels(intersect(loop, found.at("colon").mask)), 0u) << noise_hu;
        EXPECT_GT(compare(loop, found.at("small bowel").mask).dice, 0.6) << noise_hu;
        EXPECT_GT(found.at("colon").confidence, 0.5) << noise_hu;
    }
}

TEST(Organs, MatchReferencePatient) {
    const CtVolume& ct = test::seededTorso().ct;
    const Mask& body = test::seededBody();
    const Bones& bones = test::seededBones();
    const Lungs& lungs = test::seededLungs();
    const Mask liver = wholeLiver(test::seededTorso().labels, test::seededTorso().label_table);
    const FasciaInput in{ct, body, bones.all, unite(unite(lungs.right, lungs.left), liver)};
    const Mask inside = insideFascia(fitFascia(in), in);
    const Mask portal = intersect(liver, test::seededTruth({Id::portal}));
    const std::vector<FoundOrgan> organs = findOrgans({ct, body, lungs, bones, liver, portal, inside});
    const struct {
        Id id;
        double dice;
    } min_dice[] = {{Id::kidneyRight, 0.85}, {Id::kidneyLeft, 0.85},  {Id::spleen, 0.82},
                    {Id::heart, 0.75},       {Id::aorta, 0.65},       {Id::cava, 0.60},
                    {Id::portal, 0.25},      {Id::gallbladder, 0.70}, {Id::stomach, 0.55},
                    {Id::colon, 0.35},       {Id::bowel, 0.5},        {Id::gas, 0.95}};
    ASSERT_EQ(organs.size(), std::size(min_dice));
    Mask occupied = unite(unite(lungs.right, lungs.left), unite(liver, bones.all));
    for (std::size_t n = 0; n < organs.size(); ++n) {
        EXPECT_GT(test::diceWithTruth({min_dice[n].id}, organs[n].mask), min_dice[n].dice) << organs[n].name;
        EXPECT_EQ(countVoxels(intersect(organs[n].mask, occupied)), 0u) << organs[n].name;
        occupied = unite(occupied, organs[n].mask);
    }
}

}  // namespace
}  // namespace stylet::modeller
