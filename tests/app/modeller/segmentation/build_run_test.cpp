// Runs `stylet-model build` as a user does: from a CT file to a package, with stages that are reused,
// corrected, edited or cancelled.
#include <gtest/gtest.h>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>

#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/build.h"
#include "app/modeller/segmentation/morphology.h"
#include "patient/package/nifti.h"
#include "patient/synth/synth.h"
#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using patient::Package;
using test::textOf;

constexpr double kSpacing_m = 0.003;

Package referencePatient(std::uint64_t seed) {
    patient::synth::SynthSettings s;
    s.seed = seed;
    s.spacing_m = kSpacing_m;
    s.defaults = patient::loadTissueDefaults(fs::path(std::getenv("STYLET_ASSETS")) / "tissue" / "ptcd.toml");
    return patient::synth::makeReferencePatient(s);
}

class BuildRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        temp_ = new test::TempFolder;
        truth_ = new Package(referencePatient(2));
        patient::writeNifti(folder() / "ct.nii.gz", truth_->ct);
        for (const std::uint64_t seed : {11, 12})
            patient::savePackage(referencePatient(seed), folder() / ("atlas" + std::to_string(seed)));
        status_ = run();
    }
    static void TearDownTestSuite() {
        delete truth_;
        delete temp_;
    }
    static fs::path folder() { return temp_->path(); }
    static fs::path stage(const std::string& name) { return folder() / "patient-stages" / name; }
    static std::string said() { return textOf(folder() / "out"); }
    static int run(const std::string& more = "", const std::string& phase = "exhale", int atlases = 2) {
        const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) +
                                 "/stylet-model' build --ct '" + (folder() / "ct.nii.gz").string() +
                                 "' --out '" + (folder() / "patient").string() + "' --atlas '" +
                                 (folder() / "atlas11").string() +
                                 (atlases > 1 ? "' '" + (folder() / "atlas12").string() : "") +
                                 "' --spacing-mm 3 --reference-phase " + phase + " " + more + " >'" +
                                 (folder() / "out").string() + "' 2>'" + (folder() / "err").string() + "'";
        return WEXITSTATUS(std::system(line.c_str()));
    }
    // Number of stages that the last run reused.
    static int kept() {
        const std::string out = said();
        const std::regex word("  kept ");
        return int(std::distance(std::sregex_iterator(out.begin(), out.end(), word), {}));
    }

    static inline test::TempFolder* temp_ = nullptr;
    static inline Package* truth_ = nullptr;
    static inline int status_ = -1;
};

TEST_F(BuildRun, FromACtToAPackageWithALiver) {
    ASSERT_EQ(status_, 0) << said() << textOf(folder() / "err");
    const Package built = patient::loadPackage(folder() / "patient");
    EXPECT_NE(
        built.provenance.find("atlases: \"reference patient, seed 11\", \"reference patient, seed 12\""),
        std::string::npos)
        << built.provenance;
    EXPECT_EQ(built.provenance.find("seed 2"), std::string::npos) << built.provenance;
    for (const patient::Label& l : built.label_table)
        EXPECT_EQ(l.provenance.rfind("automatic: stage ", 0), 0u) << l.name << ": " << l.provenance;
    const auto isLiver = [](const patient::Label& l) { return l.tissue == patient::Tissue::liver; };
    Mask truth(built.labels.grid);
    const Mask all = maskOf(truth_->labels, isLiver);
    for (int z = 0; z < truth.grid.dims.z; ++z)
        for (int y = 0; y < truth.grid.dims.y; ++y)
            for (int x = 0; x < truth.grid.dims.x; ++x)
                truth[{x, y, z}] = all.nearestOr(truth.grid.centre({x, y, z}), 0);
    EXPECT_GT(compare(truth, maskOf(built.labels, isLiver)).dice, 0.85);
    for (const std::string& name : stageNames())
        EXPECT_NE(said().find("\n" + name), std::string::npos) << name;
}

TEST_F(BuildRun, ASecondRunKeepsEverything) {
    ASSERT_EQ(status_, 0);
    const std::string before = textOf(folder() / "patient" / "labels.nii.gz");
    ASSERT_EQ(run(), 0);
    EXPECT_EQ(kept(), int(stageNames().size())) << said();
    EXPECT_EQ(textOf(folder() / "patient" / "labels.nii.gz"), before);
}

// A corrected stage is used as it is. Only the stages after it are rebuilt.
TEST_F(BuildRun, ACorrectedStageIsTakenAndTheNextAreDoneAnew) {
    ASSERT_EQ(status_, 0);
    const std::vector<std::string> names = stageNames();
    const auto at = std::find(names.begin(), names.end(), "organs");
    ASSERT_NE(at, names.end());
    const int before = int(at - names.begin());
    const fs::path labels = stage((before + 1 < 10 ? "0" : "") + std::to_string(before + 1) + "-organs");
    LabelVolume mine = patient::readNifti<std::uint8_t>(labels / "labels.nii.gz");
    const Mask spleen = maskOf(mine, "spleen");
    for (std::size_t i = 0; i < mine.voxels.size(); ++i)
        if (spleen.voxels[i]) mine.voxels[i] = 0;
    const fs::path file = folder() / "mine.nii.gz";
    patient::writeNifti(file, mine);
    ASSERT_EQ(run("--stage organs --labels '" + file.string() + "'"), 0) << textOf(folder() / "err");
    EXPECT_EQ(kept(), before + 1) << said();
    const Package built = patient::loadPackage(folder() / "patient");
    for (const patient::Label& l : built.label_table) {
        EXPECT_NE(l.name, "spleen");
        if (l.name == "right kidney") {
            EXPECT_EQ(l.provenance, "manual: corrected in stage organs");
        }
    }
    ASSERT_EQ(run(), 0);
    EXPECT_EQ(kept(), int(names.size())) << "the correction stands\n" << said();
}

// A corrected stage keeps its provenance. Labels painted by a user override those of other stages.
// HZ-TEACH-09
TEST_F(BuildRun, ACorrectionKeepsTheProvenance) {
    ASSERT_EQ(status_, 0);
    const fs::path other = folder() / "third-stages", file = folder() / "painted.nii.gz";
    fs::copy(folder() / "patient-stages", other, fs::copy_options::recursive);
    const std::string stages = "--stages '" + other.string() + "' ";
    ASSERT_EQ(
        run(stages + "--stage liver --labels '" + (other / "05-liver" / "labels.nii.gz").string() + "'"), 0)
        << textOf(folder() / "err");
    EXPECT_NE(patient::loadPackage(folder() / "patient").provenance.find("seed 11"), std::string::npos);

    LabelVolume organs = patient::readNifti<std::uint8_t>(other / "08-organs" / "labels.nii.gz");
    const auto liver = patient::readNifti<std::uint8_t>(other / "05-liver" / "labels.nii.gz");
    std::size_t painted = 0;
    for (std::size_t i = 0; i < liver.voxels.size() && painted < 500; ++i)
        if (liver.voxels[i] && !organs.voxels[i]) organs.voxels[i] = findTarget("gallbladder")->id, ++painted;
    patient::writeNifti(file, organs);
    const auto gallbladder = [&] {
        const Package p = patient::loadPackage(folder() / "patient");
        return countOf(maskOf(p.labels, "gallbladder"));
    };
    const std::size_t before = gallbladder();
    ASSERT_EQ(run(stages + "--stage organs --labels '" + file.string() + "'"), 0) << textOf(folder() / "err");
    EXPECT_GE(gallbladder(), before + painted / 2);

    std::ofstream(other / "09-fascia" / "control-points.txt", std::ios::app) << "\n";
    LabelVolume wall = patient::readNifti<std::uint8_t>(other / "09-fascia" / "labels.nii.gz");
    wall.voxels[0] = findTarget("fascia")->id;
    patient::writeNifti(other / "09-fascia" / "labels.nii.gz", wall);
    EXPECT_EQ(run(stages), 2);
    EXPECT_NE(textOf(folder() / "err").find("both its labels and control-points.txt"), std::string::npos)
        << textOf(folder() / "err");
    EXPECT_EQ(run(stages + "--stage classes --labels '" + file.string() + "'"), 2);
    EXPECT_NE(textOf(folder() / "err").find("classes.json instead"), std::string::npos)
        << textOf(folder() / "err");
    // A correction must not be used on another CT, where it would lie in the wrong place.
    Package moved = *truth_;
    for (std::int16_t& hu : moved.ct.voxels)
        hu = std::int16_t(hu + 3);
    patient::writeNifti(folder() / "ct.nii.gz", moved.ct);
    EXPECT_EQ(run(stages), 2);
    patient::writeNifti(folder() / "ct.nii.gz", truth_->ct);
    EXPECT_NE(textOf(folder() / "err").find("was corrected by hand on another CT"), std::string::npos)
        << textOf(folder() / "err");
    ASSERT_EQ(run(), 0);
}

// A scan from the neck to the hip: repeats the first and the last slice for 150 mm each.
TEST_F(BuildRun, ALongScanIsCutAboutTheLiver) {
    ASSERT_EQ(status_, 0);
    constexpr int kMore = 50;
    const CtVolume& ct = truth_->ct;
    Grid grid = ct.grid;
    grid.dims.z += 2 * kMore;
    grid.origin_m.z -= kMore * grid.spacing_m.z;
    CtVolume tall(grid);
    for (int z = 0; z < grid.dims.z; ++z)
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x)
                tall[{x, y, z}] = ct[{x, y, std::clamp(z - kMore, 0, ct.grid.dims.z - 1)}];
    const auto liver = [&] {
        const Package p = patient::loadPackage(folder() / "patient");
        return double(countOf(maskOf(p.labels, "liver")));
    };
    const double before = liver();
    patient::writeNifti(folder() / "ct.nii.gz", tall);
    // One atlas only: its registration to such a tall scan takes most of this test's time.
    EXPECT_EQ(run("--stages '" + (folder() / "tall-stages").string() + "'", "exhale", 1), 0)
        << textOf(folder() / "err");
    patient::writeNifti(folder() / "ct.nii.gz", ct);
    EXPECT_NEAR(liver() / before, 1.0, 0.1);
    const auto kept = patient::readNifti<std::int16_t>(folder() / "tall-stages" / "ct.nii.gz");
    EXPECT_LT(kept.grid.dims.z * kept.grid.spacing_m.z, 0.45);
    ASSERT_EQ(run(), 0);
}

// The package is written for inspection, but the command reports that it cannot be simulated.
// HZ-TEACH-08
TEST_F(BuildRun, WhatCannotBeSimulatedIsSaidAtTheEnd) {
    ASSERT_EQ(status_, 0);
    EXPECT_EQ(said().find("REFUSED"), std::string::npos) << said();
    fs::copy(folder() / "patient-stages", folder() / "other-stages", fs::copy_options::recursive);
    const auto ct = patient::readNifti<std::int16_t>(folder() / "other-stages" / "ct.nii.gz");
    patient::writeNifti(folder() / "nothing.nii.gz", LabelVolume(ct.grid));
    EXPECT_EQ(run("--stages '" + (folder() / "other-stages").string() + "' --stage skin --labels '" +
                  (folder() / "nothing.nii.gz").string() + "'"),
              1)
        << textOf(folder() / "err");
    EXPECT_NE(said().find("REFUSED  skin: 0 ml, expected at least"), std::string::npos) << said();
    EXPECT_NE(said().find("The patient cannot be simulated yet"), std::string::npos) << said();
    EXPECT_TRUE(fs::exists(folder() / "patient" / "patient.toml"));
    ASSERT_EQ(run(), 0);
}

TEST_F(BuildRun, EditedControlPointsMoveTheFascia) {
    ASSERT_EQ(status_, 0);
    const std::vector<std::string> names = stageNames();
    const int number = int(std::find(names.begin(), names.end(), "fascia") - names.begin()) + 1;
    const fs::path fascia = stage((number < 10 ? "0" : "") + std::to_string(number) + "-fascia");
    const std::string text = textOf(fascia / "control-points.txt"), before = textOf(fascia / "labels.nii.gz");
    std::ofstream(fascia / "control-points.txt")
        << std::regex_replace(text, std::regex("h_begin_mm ([-0-9.]+)"), "h_begin_mm -40.5");
    ASSERT_EQ(run(), 0) << textOf(folder() / "err");
    EXPECT_NE(textOf(fascia / "labels.nii.gz"), before);
    EXPECT_NE(said().find("corrected by hand"), std::string::npos) << said();
    std::ofstream(fascia / "control-points.txt") << "nonsense\n";
    EXPECT_EQ(run(), 2);
    EXPECT_NE(textOf(folder() / "err").find("control-points.txt: line 1"), std::string::npos)
        << textOf(folder() / "err");
}

// The patient's own atlas is refused by its name, with new or reused stages, and by its CT under another
// name.
// HZ-TEACH-10
TEST_F(BuildRun, APatientIsNoAtlasOfItsOwn) {
    ASSERT_EQ(status_, 0);
    const std::string before = textOf(folder() / "patient" / "patient.toml");
    const auto refused = [](const std::string& more) {
        EXPECT_EQ(run(more), 2) << more;
        return textOf(folder() / "err");
    };
    const char* const words = "\"reference patient, seed 11\" is among the atlases of its own patient";
    const std::string name = "--name 'reference patient, seed 11'";
    EXPECT_NE(refused(name).find(words), std::string::npos);
    const std::string fresh = " --stages '" + (folder() / "fresh-stages").string() + "' ";
    EXPECT_NE(refused(name + fresh).find(words), std::string::npos);
    Package renamed = *truth_;
    renamed.name = "somebody else";
    patient::savePackage(renamed, folder() / "renamed");
    EXPECT_NE(refused("--atlas '" + (folder() / "renamed").string() + "'" + fresh)
                  .find("atlas \"somebody else\" has the very CT that is to be built from"),
              std::string::npos);
    EXPECT_EQ(textOf(folder() / "patient" / "patient.toml"), before);
}

TEST_F(BuildRun, WhatCannotBeIsRefusedInWords) {
    const auto refused = [](const std::string& more) {
        EXPECT_EQ(run(more), 2) << more;
        return textOf(folder() / "err");
    };
    EXPECT_NE(refused("--stage heart --labels x").find("\"heart\" is no stage; they are body, "),
              std::string::npos);
    EXPECT_NE(refused("--stage liver --labels /nonexistent.nii").find("nonexistent.nii"), std::string::npos);
    EXPECT_NE(refused("--stage liver --labels '" + (folder() / "atlas11/labels.nii.gz").string() + "'")
                  .find("labels.nii.gz: dim:"),
              std::string::npos);
    EXPECT_EQ(run("", "sneeze"), 2);
    EXPECT_NE(textOf(folder() / "err").find("reference phase \"sneeze\""), std::string::npos);
    EXPECT_NE(run("--stage liver"), 0);
}

}  // namespace
}  // namespace stylet::modeller
