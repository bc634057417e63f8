#include "app/modeller/segmentation/atlas.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/modeller/image/handover_files.h"
#include "app/modeller/image/image_handover.h"
#include "app/modeller/segmentation/build.h"
#include "tests/app/modeller/segmentation/torso_from_seed.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

using patient::Label;
using patient::synth::Id;

TEST(WholeLiver, IncludesVesselsInsideButNotTheTrunks) {
    LabelVolume labels({Index3(40, 30, 30), Vec3(0.002), Vec3(0.0)});
    forEachVoxel(labels.grid, [&](const Index3& i) {
        labels[i] = i.x < 20 ? 1 : 0;
        if (std::abs(i.y - 15) < 2 && std::abs(i.z - 15) < 2) labels[i] = 2;
    });
    std::vector<Label> table(2);
    table[0].id = 1, table[0].tissue = patient::Tissue::liver;
    table[1].id = 2, table[1].tissue = patient::Tissue::vessel, table[1].blood = patient::BloodKind::portal;
    const Mask whole = wholeLiver(labels, table);
    EXPECT_TRUE((whole[{10, 15, 15}]) && (whole[{18, 15, 15}]) && (whole[{10, 5, 5}]));
    EXPECT_FALSE((whole[{21, 15, 15}]) || (whole[{30, 15, 15}]));
}

// Also the core of a large one, and the part that bulges out of the parenchyma.
TEST(WholeLiver, IncludesAllOfATumour) {
    LabelVolume labels({Index3(40, 30, 30), Vec3(0.002), Vec3(0.0)});
    std::size_t expected = 0;
    forEachVoxel(labels.grid, [&](const Index3& i) {
        const Vec3 d = Vec3(i) - Vec3(18.0, 15.0, 15.0);
        labels[i] = glm::dot(d, d) < 100.0 ? 2 : i.x < 20 ? 1 : 0;
        expected += labels[i] != 0;
    });
    std::vector<Label> table(2);
    for (Label& l : table)
        l.tissue = patient::Tissue::liver;
    table[0].id = 1, table[1].id = 2, table[1].structure = patient::Structure::tumour;
    EXPECT_EQ(countVoxels(wholeLiver(labels, table)), expected);
}

TEST(Atlas, ContainsTheOrgansOfAReferencePatient) {
    const patient::Package& torso = test::seededTorso();
    const AtlasImage atlas(torso, {});
    const auto millilitres = [&](Organ organ) {
        return voxelVolume_ml(torso.ct.grid) *
               double(std::count(atlas.organ.voxels.begin(), atlas.organ.voxels.end(), std::uint8_t(organ)));
    };
    EXPECT_NEAR(millilitres(Organ::spleen), volume_ml(test::seededTruth({Id::spleen})), 1e-6);
    EXPECT_NEAR(millilitres(Organ::lungs), volume_ml(test::seededTruth({Id::lungRight, Id::lungLeft})), 1e-6);
    EXPECT_GT(millilitres(Organ::liver), volume_ml(test::seededTruth({Id::liver})));
    for (const Organ organ : {Organ::gallbladder, Organ::heart, Organ::kidneys, Organ::stomach, Organ::bowel,
                              Organ::pancreas, Organ::blood, Organ::wall})
        EXPECT_GT(millilitres(organ), 10.0) << int(organ);
    // Voxels outside the body have the lowest feature value.
    EXPECT_NEAR(atlas.feature.grid.spacing_m.x, 0.004, 1e-9);
    EXPECT_LT(*std::min_element(atlas.feature.voxels.begin(), atlas.feature.voxels.end()), -290.0f);
}

TEST(Atlas, NoAtlasesGiveAnUnknownPrior) {
    const patient::Package& torso = test::seededTorso();
    const AtlasPrior prior = alignAtlases(torso.ct, test::seededBody(), {}, {}, {});
    EXPECT_TRUE(prior.used.empty());
    EXPECT_EQ(prior.probability.size(), kOrgans);
    EXPECT_EQ(*std::max_element(prior.known.voxels.begin(), prior.known.voxels.end()), 0.0f);
}

TEST(Atlas, NeedsTheRegistrationProgram) {
    const patient::Package& torso = test::seededTorso();
    AtlasSettings settings;
    settings.spacing_m = 0.010;
    settings.program = "/nowhere/stylet-register";
    EXPECT_THROW(alignAtlases(torso.ct, test::seededBody(), {}, {AtlasImage(torso, settings)}, settings),
                 EnvironmentError);
}

// The registration program may have read a hostile file, so any of its output may be wrong.
TEST(Atlas, ATransformThatCannotBeIsRefused) {
    const test::TempFolder temp;
    const auto read = [&](const AffineHandover& h, std::size_t bytes = sizeof(AffineHandover)) {
        const auto* const first = reinterpret_cast<const std::byte*>(&h);
        test::Bytes whole(first, first + sizeof h);
        whole.resize(bytes);
        test::writeBytes(temp / "affine", whole);
        return readAffineFile(temp / "affine");
    };
    AffineHandover good;
    for (std::size_t d = 0; d < 3; ++d)
        good.matrix[d][d] = 2.0;
    good.matrix[0][1] = 1.0;
    good.centre_mm = {10.0, 0.0, 0.0}, good.shift_mm = {0.0, 0.0, 5.0};
    const Vec3 to = read(good)(Vec3(0.020, 0.003, 0.0));
    EXPECT_LT(glm::length(to - Vec3(0.010 + 0.020 + 0.003, 0.006, 0.005)), 1e-15);
    AffineHandover bad = good;
    bad.magic[0] = 'x';
    EXPECT_THROW(read(bad), ImportError);
    for (const double v : {std::nan(""), 1e9}) {
        bad = good, bad.matrix[2][1] = v;
        EXPECT_THROW(read(bad), ImportError) << v;
        bad = good, bad.centre_mm[1] = v;
        EXPECT_THROW(read(bad), ImportError) << v;
        bad = good, bad.shift_mm[2] = v;
        EXPECT_THROW(read(bad), ImportError) << v;
    }
    EXPECT_THROW(read(good, sizeof good - 1), ImportError);
    EXPECT_THROW(read(good, sizeof good + 1), ImportError);
    EXPECT_THROW(readAffineFile(temp / "none"), ImportError);
}

// Names are compared as a whole: seed 1 differs from seed 11.
// HZ-TEACH-10
TEST(Atlas, OwnPatientIsRefused) {
    // A name may contain the marks with which a text lists names.
    const std::vector<std::string> atlases{"reference patient, seed 11", "A", "B\", \"C"};
    for (const char* other : {"reference patient, seed 1", "seed 11", "B", "C", ""})
        EXPECT_NO_THROW(checkNotOwnAtlas(other, atlases)) << other;
    for (const std::string& same : atlases)
        EXPECT_THROW(checkNotOwnAtlas(same, atlases), ImportError) << same;
}

// Seeds 1 to 8 are used for tuning, seeds 31 to 33 for reported results.
// HZ-TEACH-10
TEST(Atlas, DefaultSeedsAreNotUsedForTuningOrReports) {
    for (const std::uint64_t seed : kAtlasSeeds)
        EXPECT_GT(seed, 100u);
}

}  // namespace
}  // namespace stylet::modeller
