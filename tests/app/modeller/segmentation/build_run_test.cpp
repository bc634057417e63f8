// Runs `stylet-model build` as a user does: from a CT file to a package, with stages that are reused,
// corrected, edited or cancelled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>

#include "app/modeller/image/morphology.h"
#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/accuracy.h"
#include "app/modeller/segmentation/build.h"
#include "app/modeller/segmentation/stage_store.h"
#include "patient/package/nifti.h"
#include "tests/app/modeller/reference_patient.h"
#include "tests/app/modeller/run_model.h"
#include "tests/support/file_text.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using patient::Package;
using test::readText;

constexpr double kSpacing_m = 0.003;

class BuildRun : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        temp_ = new test::TempFolder;
        truth_ = new Package(test::stillPatient(2, kSpacing_m));
        patient::writeNifti(folder() / "ct.nii.gz", truth_->ct);
        for (const std::uint64_t seed : {11, 12})
            patient::savePackage(test::referencePatient(seed, kSpacing_m),
                                 folder() / ("atlas" + std::to_string(seed)));
        status_ = run();
    }
    static void TearDownTestSuite() {
        delete truth_;
        delete temp_;
    }
    static fs::path folder() { return temp_->path(); }
    static int stageNumber(const std::string& name) {
        const std::vector<std::string> names = stageNames();
        return int(std::find(names.begin(), names.end(), name) - names.begin()) + 1;
    }
    static fs::path stage(const std::string& name) {
        return StageStore(folder() / "patient-stages").stageFolder(stageNumber(name), name);
    }
    static const std::string& output() { return last_.out; }
    static const std::string& errors() { return last_.err; }
    // Builds the package `out`, and without --stages in `more` its stages beside it.
    static int runInto(const std::string& out, const std::string& more, const std::string& phase = "exhale") {
        last_ = test::runModel("build --ct '" + (folder() / "ct.nii.gz").string() + "' --out '" +
                               (folder() / out).string() + "' --atlas '" + (folder() / "atlas11").string() +
                               "' '" + (folder() / "atlas12").string() +
                               "' --spacing-mm 3 --reference-phase " + phase + " " + more);
        return last_.status;
    }
    static int run(const std::string& more = "", const std::string& phase = "exhale") {
        return runInto("patient", more, phase);
    }
    static const std::string& refused(const std::string& more) {
        EXPECT_EQ(run(more), 2) << more;
        return errors();
    }
    // Writes the scan and builds it with one atlas, beside the patient that most tests share.
    static test::ModelRun buildScan(const CtVolume& ct, const std::string& name,
                                    const std::string& more = "") {
        const std::string file = (folder() / (name + ".nii.gz")).string();
        patient::writeNifti(file, ct);
        return test::runModel("build --ct '" + file + "' --out '" + (folder() / name).string() +
                              "' --atlas '" + (folder() / "atlas11").string() +
                              "' --spacing-mm 3 --reference-phase exhale " + more);
    }
    // Number of stages that the last run reused.
    static int kept() {
        const std::regex word("  kept ");
        return int(std::distance(std::sregex_iterator(output().begin(), output().end(), word), {}));
    }

    static inline test::TempFolder* temp_ = nullptr;
    static inline Package* truth_ = nullptr;
    static inline int status_ = -1;
    static inline test::ModelRun last_;
};

// A scan from the neck to the hip: repeats the first and the last slice for 150 mm each.
CtVolume tallScan(const CtVolume& ct) {
    constexpr int kMore = 50;
    Grid grid = ct.grid;
    grid.dims.z += 2 * kMore;
    grid.origin_m.z -= kMore * grid.spacing_m.z;
    CtVolume tall(grid);
    forEachVoxel(grid, [&](const Index3& i) {
        tall[i] = ct[{i.x, i.y, std::clamp(i.z - kMore, 0, ct.grid.dims.z - 1)}];
    });
    return tall;
}

struct ReversedAxes {
    bool x = false, y = false, z = false;
};
CtVolume reversedScan(const CtVolume& ct, const ReversedAxes& axes) {
    CtVolume out(ct.grid);
    const Index3 last = ct.grid.dims - 1;
    forEachVoxel(ct.grid, [&](const Index3& i) {
        out[i] = ct[{axes.x ? last.x - i.x : i.x, axes.y ? last.y - i.y : i.y, axes.z ? last.z - i.z : i.z}];
    });
    return out;
}

TEST_F(BuildRun, BuildsAPackageWithALiverFromACt) {
    ASSERT_EQ(status_, 0) << output() << errors();
    EXPECT_THAT(output(), testing::Not(testing::HasSubstr("REFUSED")));
    const Package built = patient::loadPackage(folder() / "patient");
    EXPECT_THAT(built.atlases,
                testing::ElementsAre("reference patient, seed 11", "reference patient, seed 12"));
    EXPECT_THAT(built.provenance, testing::Not(testing::HasSubstr("seed"))) << "the atlases have one home";
    EXPECT_NEAR(built.scan.slice_m, kSpacing_m, 1e-9);
    EXPECT_THAT(output(), testing::HasSubstr("atlases: \"reference patient, seed 11\", "));
    for (const patient::Label& l : built.label_table)
        EXPECT_EQ(l.provenance.rfind("automatic: stage ", 0), 0u) << l.name << ": " << l.provenance;
    const auto isLiver = [](const patient::Label& l) { return l.tissue == patient::Tissue::liver; };
    Mask truth(built.labels.grid);
    const Mask all = labelMask(truth_->labels, isLiver);
    forEachVoxel(truth.grid, [&](const Index3& i) { truth[i] = all.nearestOr(truth.grid.centre(i), 0); });
    EXPECT_GT(compare(truth, labelMask(built.labels, isLiver)).dice, 0.85);
    for (const std::string& name : stageNames())
        EXPECT_THAT(output(), testing::HasSubstr("\n" + name)) << name;
}

// Calcifications of the liver are neither bone, which stops a needle, nor vessels.
TEST_F(BuildRun, ACalcifiedTumourIsLiver) {
    constexpr std::int16_t kDenserThanBlood_hu = 400;
    const std::string truth = (folder() / "calcified").string();
    const test::ModelRun made =
        test::runModel("synth --seed 2 --spacing-mm 3 --variant calcified-tumour --out '" + truth + "'");
    ASSERT_EQ(made.status, 0) << made.err;
    const Package real = patient::loadPackage(truth);
    const test::ModelRun run = buildScan(real.ct, "built");
    ASSERT_EQ(run.status, 0) << run.out << run.err;
    EXPECT_THAT(run.out, testing::HasSubstr("taken for calcified liver"));
    const Package built = patient::loadPackage(folder() / "built");
    const Mask tumour =
        labelMask(real.labels, real.label_table, [](const patient::Label& l) { return l.name == "tumour"; });
    std::map<std::string, std::size_t> found;
    forEachVoxel(built.labels.grid, [&](const Index3& i) {
        if (built.ct[i] < kDenserThanBlood_hu || !tumour.nearestOr(built.labels.grid.centre(i), 0)) return;
        std::string name = "unlabelled";  // thresholds would take it for bone
        for (const patient::Label& l : built.label_table)
            if (l.id == built.labels[i]) name = l.name;
        ++found[name];
    });
    EXPECT_GT(found["liver"], 20u);
    EXPECT_EQ(found.size(), 1u) << testing::PrintToString(found);
}

TEST_F(BuildRun, SecondRunReusesAllStages) {
    ASSERT_EQ(status_, 0);
    const std::string before = readText(folder() / "patient" / "labels.nii.gz");
    ASSERT_EQ(run(), 0);
    EXPECT_EQ(kept(), int(stageNames().size())) << output();
    EXPECT_EQ(readText(folder() / "patient" / "labels.nii.gz"), before);
}

// A stage that the user corrected is used unchanged. Only the stages after it are rebuilt.
TEST_F(BuildRun, CorrectedStageIsUsedAndLaterStagesRerun) {
    ASSERT_EQ(status_, 0);
    const int before = stageNumber("organs") - 1;
    LabelVolume mine = patient::readNifti<std::uint8_t>(stage("organs") / "labels.nii.gz");
    const Mask spleen = labelMask(mine, "spleen");
    for (std::size_t i = 0; i < mine.voxels.size(); ++i)
        if (spleen.voxels[i]) mine.voxels[i] = 0;
    mine.voxels[mine.voxels.size() / 2] = targetId("left kidney");
    const fs::path file = folder() / "mine.nii.gz";
    patient::writeNifti(file, mine);
    ASSERT_EQ(run("--stage organs --labels '" + file.string() + "'"), 0) << errors();
    EXPECT_EQ(kept(), before + 1) << output();
    const Package built = patient::loadPackage(folder() / "patient");
    // Of the organs found, only the left kidney was corrected.
    int corrected = 0, uncertain = 0;
    for (const patient::Label& l : built.label_table) {
        EXPECT_NE(l.name, "spleen");
        if (l.name == "left kidney") {
            EXPECT_EQ(l.provenance, "manual: corrected in stage organs");
            EXPECT_EQ(l.border_uncertainty_m, 0.0);
            ++corrected;
        } else if (l.provenance == "automatic: stage organs" && l.role == patient::Role::risk) {
            EXPECT_EQ(l.border_uncertainty_m, kSpacing_m) << l.name;
            ++uncertain;
        }
    }
    EXPECT_EQ(corrected, 1);
    EXPECT_GT(uncertain, 0);
    ASSERT_EQ(run(), 0);
    EXPECT_EQ(kept(), int(stageNames().size())) << "the correction stands\n" << output();
}

// A corrected stage keeps its provenance. Labels painted by a user override those of other stages.
// HZ-TEACH-09
TEST_F(BuildRun, CorrectionKeepsTheProvenance) {
    ASSERT_EQ(status_, 0);
    const fs::path other = folder() / "third-stages", file = folder() / "painted.nii.gz";
    fs::copy(folder() / "patient-stages", other, fs::copy_options::recursive);
    const auto runOther = [&other](const std::string& more) {
        return runInto("third", "--stages '" + other.string() + "' " + more);
    };
    ASSERT_EQ(runOther("--stage liver --labels '" + (other / "05-liver" / "labels.nii.gz").string() + "'"), 0)
        << errors();
    EXPECT_THAT(patient::loadPackage(folder() / "third").atlases,
                testing::Contains("reference patient, seed 11"));

    LabelVolume organs = patient::readNifti<std::uint8_t>(other / "08-organs" / "labels.nii.gz");
    const auto liver = patient::readNifti<std::uint8_t>(other / "05-liver" / "labels.nii.gz");
    std::size_t painted = 0;
    for (std::size_t i = 0; i < liver.voxels.size() && painted < 500; ++i)
        if (liver.voxels[i] && !organs.voxels[i]) organs.voxels[i] = targetId("gallbladder"), ++painted;
    patient::writeNifti(file, organs);
    const auto gallbladder = [&] {
        const Package p = patient::loadPackage(folder() / "third");
        return countVoxels(labelMask(p.labels, "gallbladder"));
    };
    const std::size_t before = gallbladder();
    ASSERT_EQ(runOther("--stage organs --labels '" + file.string() + "'"), 0) << errors();
    EXPECT_GE(gallbladder(), before + painted / 2);

    std::ofstream(other / "09-fascia" / "control-points.txt", std::ios::app) << "\n";
    LabelVolume wall = patient::readNifti<std::uint8_t>(other / "09-fascia" / "labels.nii.gz");
    wall.voxels[0] = targetId("fascia");
    patient::writeNifti(other / "09-fascia" / "labels.nii.gz", wall);
    EXPECT_EQ(runOther(""), 2);
    EXPECT_THAT(errors(), testing::HasSubstr("both its labels and control-points.txt"));
    EXPECT_EQ(runOther("--stage classes --labels '" + file.string() + "'"), 2);
    EXPECT_THAT(errors(), testing::HasSubstr("classes.json instead"));
    // A correction must not be used on another CT, where it would lie in the wrong place.
    Package moved = *truth_;
    for (std::int16_t& hu : moved.ct.voxels)
        hu = std::int16_t(hu + 3);
    patient::writeNifti(folder() / "ct.nii.gz", moved.ct);
    EXPECT_EQ(runOther(""), 2);
    patient::writeNifti(folder() / "ct.nii.gz", truth_->ct);
    EXPECT_THAT(errors(), testing::HasSubstr("was corrected by hand on another CT"));
}

TEST_F(BuildRun, LongScanIsCroppedToTheLiver) {
    ASSERT_EQ(status_, 0);
    const auto liver = [](const char* package) {
        const Package p = patient::loadPackage(folder() / package);
        return double(countVoxels(labelMask(p.labels, "liver")));
    };
    const test::ModelRun run = buildScan(tallScan(truth_->ct), "tall");
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_NEAR(liver("tall") / liver("patient"), 1.0, 0.1);
    const auto kept = patient::readNifti<std::int16_t>(folder() / "tall-stages" / "ct.nii.gz");
    EXPECT_LT(kept.grid.dims.z * kept.grid.spacing_m.z, 0.45);
}

// Cropping assumes that the head is up, so the check comes first.
TEST_F(BuildRun, LongScanUpsideDownIsRefused) {
    const test::ModelRun run = buildScan(reversedScan(tallScan(truth_->ct), {.z = true}), "tall-upside-down");
    EXPECT_EQ(run.status, 2) << run.out;
    EXPECT_THAT(run.err, testing::HasSubstr("the scan is upside down"));
    EXPECT_FALSE(fs::exists(folder() / "tall-upside-down-stages"));
}

// The package is written for inspection, but the command reports that it cannot be simulated.
// HZ-TEACH-08
TEST_F(BuildRun, UnusablePatientIsReportedAtTheEnd) {
    ASSERT_EQ(status_, 0);
    fs::copy(folder() / "patient-stages", folder() / "other-stages", fs::copy_options::recursive);
    const auto ct = patient::readNifti<std::int16_t>(folder() / "other-stages" / "ct.nii.gz");
    patient::writeNifti(folder() / "nothing.nii.gz", LabelVolume(ct.grid));
    EXPECT_EQ(runInto("other", "--stage skin --labels '" + (folder() / "nothing.nii.gz").string() + "'"), 1)
        << errors();
    EXPECT_THAT(output(), testing::HasSubstr("REFUSED  skin: 0 ml, expected at least"));
    EXPECT_THAT(output(), testing::HasSubstr("The patient cannot be simulated yet"));
    EXPECT_TRUE(fs::exists(folder() / "other" / "patient.toml"));
}

TEST_F(BuildRun, EditedControlPointsMoveTheFascia) {
    ASSERT_EQ(status_, 0);
    const fs::path fascia = stage("fascia");
    const std::string text = readText(fascia / "control-points.txt"),
                      before = readText(fascia / "labels.nii.gz");
    std::ofstream(fascia / "control-points.txt")
        << std::regex_replace(text, std::regex("h_begin_mm ([-0-9.]+)"), "h_begin_mm -40.5");
    ASSERT_EQ(run(), 0) << errors();
    EXPECT_NE(readText(fascia / "labels.nii.gz"), before);
    EXPECT_THAT(output(), testing::HasSubstr("corrected by hand"));
    std::ofstream(fascia / "control-points.txt") << "nonsense\n";
    EXPECT_EQ(run(), 2);
    EXPECT_THAT(errors(), testing::HasSubstr("control-points.txt: line 1"));
}

// If a scan's file gives wrong axes, the refusal names them.
TEST_F(BuildRun, WrongAxesAreNamed) {
    struct Case {
        ReversedAxes reversed;
        const char* reason;
    };
    for (const Case& wrong : {Case{{.x = true}, "left and right of the scan are exchanged"},
                              Case{{.x = true, .y = true}, "front and back of the scan are exchanged"},
                              Case{{.x = true, .z = true}, "the scan is upside down"}}) {
        const test::ModelRun run = buildScan(reversedScan(truth_->ct, wrong.reversed), "wrong");
        EXPECT_EQ(run.status, 2) << run.out;
        EXPECT_THAT(run.err, testing::HasSubstr("wrong.nii.gz: axes: " + std::string(wrong.reason)));
        EXPECT_THAT(run.err, testing::HasSubstr("--trust-axes"));
    }
}

// A person may know better than the checks. The package says so, and does not pass for a checked one.
TEST_F(BuildRun, TrustedAxesAreNotChecked) {
    const CtVolume mirrored = reversedScan(truth_->ct, {.x = true});
    const test::ModelRun trusted = buildScan(mirrored, "mirrored", "--trust-axes");
    EXPECT_LE(trusted.status, 1) << trusted.err;
    EXPECT_THAT(patient::loadPackage(folder() / "mirrored").provenance,
                testing::HasSubstr("the axes of the scan were trusted, not checked"));
    const test::ModelRun checked = buildScan(mirrored, "mirrored");
    EXPECT_EQ(checked.status, 2);
    EXPECT_THAT(checked.err, testing::HasSubstr("left and right of the scan are exchanged"));
}

// A patient's own atlas is refused. It is recognised by its name, with new and with reused stages. Under
// another name it is recognised by its CT.
// HZ-TEACH-10
TEST_F(BuildRun, PatientAsItsOwnAtlasIsRefused) {
    ASSERT_EQ(status_, 0);
    const std::string before = readText(folder() / "patient" / "patient.toml");
    const char* const words = "\"reference patient, seed 11\" is among the atlases of its own patient";
    const std::string name = "--name 'reference patient, seed 11'";
    EXPECT_THAT(refused(name), testing::HasSubstr(words));
    const std::string fresh = " --stages '" + (folder() / "fresh-stages").string() + "' ";
    EXPECT_THAT(refused(name + fresh), testing::HasSubstr(words));
    Package renamed = *truth_;
    renamed.name = "somebody else";
    patient::savePackage(renamed, folder() / "renamed");
    EXPECT_THAT(refused("--atlas '" + (folder() / "renamed").string() + "'" + fresh),
                testing::HasSubstr("atlas \"somebody else\" has the CT that is to be segmented"));
    EXPECT_EQ(readText(folder() / "patient" / "patient.toml"), before);
}

TEST_F(BuildRun, InvalidArgumentsAreRefusedWithAMessage) {
    EXPECT_THAT(refused("--stage heart --labels x"),
                testing::HasSubstr("\"heart\" is no stage; they are body, "));
    EXPECT_THAT(refused("--stage liver --labels /nonexistent.nii"), testing::HasSubstr("nonexistent.nii"));
    EXPECT_THAT(refused("--stage liver --labels '" + (folder() / "atlas11/labels.nii.gz").string() + "'"),
                testing::HasSubstr("labels.nii.gz: dim:"));
    EXPECT_EQ(run("", "sneeze"), 2);
    EXPECT_THAT(errors(), testing::HasSubstr("reference phase \"sneeze\""));
    EXPECT_NE(run("--stage liver"), 0);
}

}  // namespace
}  // namespace stylet::modeller
