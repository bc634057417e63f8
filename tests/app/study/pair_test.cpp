#include "app/study/pair.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/app/study/pairs.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::study {
namespace {

class StudyFileOnDisk : public ::testing::Test {
  protected:
    StudyFile read(const std::string& text) {
        std::ofstream(file_) << text;
        return readStudyFile(file_);
    }
    void expectRefusedAs(const std::string& text, const std::string& field) {
        test::expectRefused([&] { read(text); }, "study.toml", field);
    }
    test::TempFolder temp_;
    std::filesystem::path file_ = temp_ / "study.toml";
};

TEST_F(StudyFileOnDisk, ListsPairsRelativeToItself) {
    const StudyFile study = read(
        "tissue = 'own.toml'\n"
        "[[pair]]\nreference = 'truth/a'\nfound = '../built/a/'\n"
        "[[pair]]\nname = 'the second'\nreference = '/data/b/'\nfound = 'b'\n");
    ASSERT_EQ(study.pairs.size(), 2u);
    EXPECT_EQ(study.tissue, temp_ / "own.toml");
    EXPECT_EQ(study.pairs[0].name, "a");
    EXPECT_EQ(study.pairs[0].reference, temp_ / "truth/a");
    EXPECT_EQ(study.pairs[0].found.parent_path().filename(), "a");
    EXPECT_EQ(study.pairs[1].name, "the second");
    EXPECT_EQ(study.pairs[1].reference, "/data/b/");
}

TEST_F(StudyFileOnDisk, IsRefusedWithFieldAndReason) {
    const std::string pair = "[[pair]]\nreference = 'a'\nfound = 'b'\n";
    expectRefusedAs("", "pair: a study needs at least one");
    expectRefusedAs("pair = 3", "pair");
    expectRefusedAs("pair = [3]", "pair[0]: not a table");
    expectRefusedAs("pear = 1\n" + pair, "pear: unknown key");
    expectRefusedAs("tissue = 1\n" + pair, "tissue");
    expectRefusedAs("[[pair]]\nfound = 'b'", "pair[0].reference");
    expectRefusedAs("[[pair]]\nreference = 'a'\nfound = ''", "pair[0].found");
    expectRefusedAs(pair + "colour = 'red'", "pair[0].colour: unknown key");
    expectRefusedAs(pair + "name = '../x'", "pair[0].name");
    expectRefusedAs(pair + "name = '..'", "pair[0].name");
    expectRefusedAs(pair + "name = 'summary.json'", "pair[0].name");
    expectRefusedAs(pair + pair, "pair[1].name: \"a\" is the name of an earlier pair");
    expectRefusedAs("[[pair]\n", "line 1");
    expectRefusedAs("pair = " + std::string(100'000, '['), "line 1");
    expectRefusedAs("[[pair]]\nreference = '/'\nfound = 'b'", "pair[0].name");
    std::string many;
    for (int i = 0; i < 1001; ++i)
        many += "[[pair]]\nname = '" + std::to_string(i) + "'\nreference = 'a'\nfound = 'b'\n";
    expectRefusedAs(many, "pair: more than 1000");
    expectRefusedAs(std::string((1 << 20) + 1, '#'), "file: larger");
    test::expectRefused([] { readStudyFile("/nowhere/study.toml"); }, "study.toml", "file");
}

// HZ-TEACH-22
TEST(StudyPair, RefusedPackagesNeedTheFlag) {
    const test::TempFolder temp;
    const PairFiles files{"made", temp / "truth", temp / "built"};
    const patient::Package truth = test::slabs(0.02);
    patient::Package found = truth;
    test::markAsBuilt(found);
    patient::savePackage(truth, files.reference);
    patient::savePackage(found, files.found);
    EXPECT_TRUE(loadPair(files, FoundLabels::all).implausible.empty());  // not checked
    patient::saveVerdict({patient::digest(found), true, {"REFUSED  skin: 0 ml"}}, files.found);
    EXPECT_THROW(loadPair(files, FoundLabels::all), DataError);
    const Pair pair = loadPair(files, FoundLabels::all, nullptr, true);
    ASSERT_EQ(pair.implausible.size(), 1u);
    EXPECT_NE(pair.implausible.front().find("skin: 0 ml"), std::string::npos);
}

TEST(StudyPair, FoundPackageIsMovedToTheReferenceGrid) {
    const patient::Package& truth = test::seededTruth();
    patient::TissueTable own = truth.tissues;
    own[std::size_t(patient::Tissue::fascia)].cut_force_n = 3.0;
    const patient::Package found = test::movedAndCut(truth);
    const Pair pair = makePair(test::kTestFiles, truth, found, FoundLabels::all, &own);
    EXPECT_EQ(pair.found.ct.grid, truth.ct.grid);
    EXPECT_EQ(pair.found.labels.grid, truth.ct.grid);
    EXPECT_EQ(pair.found.tissues, own);
    EXPECT_EQ(pair.reference.tissues, own);
    EXPECT_EQ(pair.found.motion, truth.motion);
    const Index3 inside{60, 50, 40};
    EXPECT_EQ(pair.found.labels[inside], truth.labels[inside + Index3(0, 0, 1)]);
    EXPECT_EQ(pair.found.ct.voxels.front(), -1024);
    // For the partial segmentation, thresholds are applied to the original CT.
    EXPECT_EQ(makePair(test::kTestFiles, truth, found, FoundLabels::partial).found.ct.voxels,
              truth.ct.voxels);
    EXPECT_GT(pair.reference_share, 0.9);
}

// HZ-TEACH-11
TEST(StudyPair, DifferentCtsAreRefused) {
    const patient::Package truth = test::slabs(0.02);
    patient::Package found = truth;
    test::markAsBuilt(found);
    const auto expectRefusedAs = [&](const std::string& field) {
        test::expectRefused([&] { makePair(test::kTestFiles, truth, found, FoundLabels::partial); },
                            "built/ct.nii.gz", field);
    };
    makePair(test::kTestFiles, truth, found, FoundLabels::partial);
    found.ct.voxels[found.ct.voxels.size() / 2] += 1;
    expectRefusedAs(
        "voxels: 0.0 % of its voxels in the body are not those of truth/ct.nii.gz: build it from that file, "
        "not from another CT or cut");
    found.ct.voxels[found.ct.voxels.size() / 2] = -1024;  // masked to the body
    makePair(test::kTestFiles, truth, found, FoundLabels::partial);
    found.ct.grid.origin_m.x += 0.0001;
    expectRefusedAs("origin");
    found.ct.grid = truth.ct.grid;
    found.ct.grid.spacing_m.z *= 2.0;
    expectRefusedAs("spacing: voxels of 0.500 x 1.000 x 2.000 mm");
    found.ct.grid = truth.ct.grid;
    std::fill(found.ct.voxels.begin(), found.ct.voxels.end(), std::int16_t(-1024));
    expectRefusedAs("voxels: 100.0 %");
}

// HZ-TEACH-11
TEST(StudyPair, DependentLabelsAreRefused) {
    const patient::Package truth = test::slabs(0.02);
    const auto expectRefusedAs = [&](const patient::Package& found, const std::string& field) {
        test::expectRefused([&] { makePair(test::kTestFiles, truth, found, FoundLabels::partial); },
                            "built/patient.toml", field);
    };
    expectRefusedAs(truth,
                    "label.skin.provenance: \"phantom\" is also the provenance of the reference's skin");
    patient::Package found = truth;
    test::markAsBuilt(found);
    patient::Package named = truth;
    named.name = "reference patient, seed 1";
    found.provenance = "built; compared with \"reference patient, seed 1\"";  // a text for people
    found.atlases = {"reference patient, seed 10", "reference patient, seed 2"};
    makePair(test::kTestFiles, named, found, FoundLabels::partial);
    found.provenance = "";
    found.atlases.push_back("reference patient, seed 1");
    test::expectRefused([&] { makePair(test::kTestFiles, named, found, FoundLabels::partial); },
                        "built/patient.toml", "atlases: reference patient, seed 1 was one of its atlases");
}

}  // namespace
}  // namespace stylet::study
