// Tests with the real data set, if it is available. It is read and built once, at 1.5 mm to save time, then
// used for path planning and punctures.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>

#include "app/modeller/image/morphology.h"
#include "app/modeller/import/import.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/vessels.h"
#include "app/report/palpation.h"
#include "app/trainer/stores/patient_source.h"
#include "base/distance.h"
#include "patient/patient.h"
#include "tests/app/modeller/outside.h"
#include "tests/app/trainer/assets.h"
#include "tests/app/trainer/command.h"
#include "tests/app/trainer/scripted_attempt.h"
#include "tests/patient/blood_facts.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;

// Writes the label map that a user would write for this data set, from the names supplied with it. Its
// label codes are not stored here.
void writeMap(const fs::path& names, const fs::path& map) {
    const std::pair<const char*, const char*> tissues[] = {
        {"outside", "unsegmented"},
        {"skin/body", "unsegmented"},
        {"portal vein", "portal vein"},
        {"bone", "bone"},
        {"left kidney", "left kidney"},
        {"right kidney", "right kidney"},
        {"left lung", "left lung"},
        {"right lung", "right lung"},
        {"spleen", "spleen"},
        {"liver tumour", "tumour"},
        {"liver cyst", "cyst"},
        {"liver parenchyma", "liver"},
        {"artery", "aorta and arteries"},
        {"hepatic veins", "hepatic veins"},
        {"venous system", "vena cava and renal veins"},
    };
    std::ifstream in(names);
    std::ofstream out(map);
    out << "# source: 3D-IRCADb-01 patient 1, IRCAD Strasbourg\n# licence: CC BY-NC-ND "
           "3.0\nsource_id,tissue\n";
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        const std::string id = line.substr(0, line.find(',')), meaning = line.substr(id.size() + 1);
        for (const auto& [begin, tissue] : tissues)
            if (meaning.starts_with(begin)) out << id << ',' << tissue << '\n';
    }
}

class ImportReal : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        const char* data = std::getenv("STYLET_DATA");
        if (!data) {
            skip_reason_ = "STYLET_DATA is not set: it names the folder that holds 3dircadb01_p01/";
            return;
        }
        const fs::path folder = fs::path(data) / "3dircadb01_p01";
        const fs::path archive = folder / "PATIENT_DICOM_p01.tar.gz";
        for (const fs::path& file : {archive, folder / "seg.nii.gz", folder / "labels.csv"})
            if (!fs::exists(file)) {
                skip_reason_ = "STYLET_DATA is set, but there is no " + file.string();
                return;
            }
        const test::TempFolder temp, map;
        writeMap(folder / "labels.csv", map / "map.csv");
        const std::string unpack = "tar xzf '" + archive.string() + "' -C '" + temp.path().string() + "'";
        ASSERT_EQ(std::system(unpack.c_str()), 0) << unpack;
        const fs::path assets = std::getenv("STYLET_ASSETS");
        ImportSettings s;
        s.ct = temp.path();
        s.labels = folder / "seg.nii.gz";
        s.map = map / "map.csv";
        s.grow_ducts = true;
        s.spacing_m = 0.0015;
        s.defaults = patient::loadTissueDefaults(assets / "tissue/ptcd.toml");
        s.reader.program = fs::path(std::getenv("STYLET_BIN")) / "stylet-image-reader";
        imported_ = new ImportResult(importPatient(s));
        command_ = new test::Command;
        patient::savePackage(imported_->package, packageFolder());
    }
    static void TearDownTestSuite() {
        delete command_;
        delete imported_;
    }
    void SetUp() override {
        if (!skip_reason_.empty()) GTEST_SKIP() << skip_reason_;
        ASSERT_NE(imported_, nullptr);
    }
    static fs::path packageFolder() { return *command_ / "patient"; }
    // The package as the trainer opens it.
    static const patient::Package& opened() {
        static const patient::Package package = patient::loadPackage(packageFolder());
        return package;
    }
    // Planned once, by the first test or program that needs them.
    static std::vector<patient::PlannedPath> paths() {
        return trainer::goodPaths(patient::Patient(opened()), packageFolder(), {});
    }

    static inline std::string skip_reason_;
    static inline ImportResult* imported_ = nullptr;
    static inline test::Command* command_ = nullptr;
};

TEST_F(ImportReal, RibsArePalpable) {
    const patient::Patient patient(imported_->package);
    const patient::Skin skin = makeSkin(patient, 2);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient, skin, 2);
    for (const bool breathing : {false, true}) {
        report::PalpationSettings settings;
        settings.breathing = breathing;
        const report::PalpationMap map = report::palpate(patient, skin, touch, settings);
        EXPECT_GE(map.pearson, 0.7) << breathing;
        EXPECT_GE(map.ribOverGap(), 3.0) << breathing;
        EXPECT_GE(map.rib_over_gap_everywhere, 3.0) << breathing;
    }
}

// The same patient, deformed by up to 6 mm in each direction. `variant` selects the deformation; 0 is none.
patient::Package deformed(const patient::Package& p, int variant) {
    constexpr double kAmplitude_m = 0.006, kPeriod_m = 0.140;
    patient::Package out = p;
    if (variant == 0) return out;
    const FloatVolume hu = toFloat(p.ct);
    parallelVoxels(p.ct.grid, [&](const Index3& i) {
        const Vec3 at = p.ct.grid.centre(i), phase = 2.0 * std::numbers::pi / kPeriod_m * at + 1.7 * variant;
        const Vec3 from = at + kAmplitude_m * Vec3(std::sin(phase.y + 2.0 * variant), std::sin(phase.z),
                                                   std::sin(phase.x + 4.0 * variant));
        out.ct[i] = std::int16_t(std::lround(sampleTrilinear(hu, from)));
        out.labels[i] = p.labels.nearestOr(from, 0);
    });
    return out;
}

// Portal and hepatic veins must be told apart in other bodies than this one, too.
TEST_F(ImportReal, VeinsAreToldApartInDeformedPatients) {
    for (const int variant : {0, 1, 2, 3, 4, 5}) {
        const patient::Package p = deformed(imported_->package, variant);
        const auto labelled = [&](const char* name) { return labelMask(p.labels, name); };
        const Mask portal = labelled("portal vein"), hepatic = labelled("hepatic veins");
        const Mask solid =
            unite(unite(labelled("liver"), labelled("tumour")), unite(labelled("bile ducts"), hepatic));
        const Mask liver = unite(solid, intersect(portal, closed(solid, 0.008)));
        const SplitVessels split = splitVessels(p.ct, liver, findVessels(p.ct, liver).vessels);
        const auto right = [&](const Mask& of, const Mask& found, const Mask& other) {
            const auto yes = double(countVoxels(intersect(of, found)));
            EXPECT_GT(yes, 0.25 * double(countVoxels(intersect(of, liver)))) << variant;
            return yes / (yes + double(countVoxels(intersect(of, other))));
        };
        EXPECT_GT(right(portal, split.portal, split.hepatic), 0.85) << variant;
        EXPECT_GT(right(hepatic, split.hepatic, split.portal), 0.8) << variant;
    }
}

// A clinical fascia with seven ribs on each side must neither tear nor fold, even at 25 mm of travel. In the
// voxels of this test (1.5 mm) the fascia has a rough groove at the midline. With 25 mm, gaps and overlaps
// are therefore up to 0.54 mm (0.39 mm in voxels of 1 mm), and a breath three times as deep as in life would
// fold.
TEST_F(ImportReal, CavitySlidesWithoutGapOrFold) {
    const patient::Package& p = imported_->package;
    struct Travel {
        double dome_m, tolerance_m, scale_without_fold;
    };
    for (const Travel t :
         {Travel{0.015, 0.0005, 3.0}, Travel{0.020, 0.0005, 3.0}, Travel{0.025, 0.0006, 2.0}}) {
        SCOPED_TRACE(t.dome_m);
        patient::MotionAmplitudes amplitudes;
        amplitudes.dome_m = t.dome_m;
        const patient::MotionModel m =
            patient::motionTemplate(p.labels, p.label_table, amplitudes, p.motion.reference);
        const patient::InterfaceError error = patient::worstInterface(m);
        EXPECT_LT(error.worst_gap_m, t.tolerance_m);
        EXPECT_LT(error.worst_overlap_m, t.tolerance_m);
        EXPECT_GT(error.mean_slip_m, 0.5 * t.dome_m);
        EXPECT_GT(patient::minJacobian(m, t.scale_without_fold), 0.0);
    }
}

// The trainees rank from the expert to the reckless one, as on the reference patients
// (tests/app/trainer/attempt/trainees_test.cpp).
TEST_F(ImportReal, SimulatedTraineesRankInOrder) {
    const patient::Patient patient(opened());
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    patient::PlannedPath path = paths().front();
    const auto play = [&](const std::string& name) {
        const trainer::Scenario scenario =
            trainer::loadScenario(test::assets() / "scenarios" / (name + ".toml"));
        return test::playScripted(patient, touch, path, scenario, 1);
    };
    // The best path on which the expert's script does not slide past a rib without feeling it.
    for (std::size_t i = 0; i < std::min<std::size_t>(10, paths().size()); ++i) {
        path = paths()[i];
        const training::Progress progress = play("procedure").progress;
        if (progress.steps_done == training::stepsOf(progress)) break;
    }
    double last = 101.0;
    for (const std::string name : {"procedure", "trainee-good", "trainee-hesitant", "trainee-sloppy",
                                   "trainee-careless", "trainee-reckless"}) {
        SCOPED_TRACE(name);
        const trainer::SessionLog log = play(name);
        EXPECT_LT(log.score.total, last);
        last = log.score.total;
        if (name == "procedure") {
            EXPECT_GT(log.score.total, 90.0);
            EXPECT_EQ(log.progress.steps_done, training::stepsOf(log.progress));
        }
        if (name == "trainee-reckless") {
            EXPECT_LT(log.score.total, 40.0);
        }
    }
}

TEST_F(ImportReal, BloodFlowsInAnatomicalDirections) {
    const patient::Patient patient(imported_->package);
    test::expectBloodFlowDirections(patient);
}

TEST_F(ImportReal, VolumesMatchPublishedValues) {
    // These three values come from the published description of the data.
    std::map<int, double> ml;
    for (const SourceLabel& s : imported_->sources)
        ml[s.id] = s.volume_ml;
    EXPECT_NEAR(ml[449], 1349.0, 1.0);
    EXPECT_NEAR(ml[465], 11.7, 0.1);
    EXPECT_NEAR(ml[481], 17.4, 0.1);
    // The volume of the liver in the package is that of the original liver, minus the ducts and the part that
    // became fascia.
    double liver = 0.0, ducts = 0.0;
    for (std::uint8_t id : imported_->package.labels.voxels)
        liver += id == targetId("liver"), ducts += id == targetId("bile ducts");
    const double voxel_ml = 0.15 * 0.15 * 0.15;
    EXPECT_NEAR((liver + ducts) * voxel_ml, 1349.0, 15.0);
    EXPECT_GT(ducts * voxel_ml, 8.0);
    EXPECT_LT(ducts * voxel_ml, 45.0);
}

// HZ-TEACH-03
TEST_F(ImportReal, LiverIsOnTheRightAndSpleenOnTheLeft) {
    const auto& v = imported_->package.labels;
    double liver = 0.0, liver_count = 0.0, spleen = 0.0, spleen_count = 0.0;
    forEachVoxel(v.grid, [&](const Index3& i) {
        const std::uint8_t id = v[i];
        if (id == targetId("liver")) liver += i.x, liver_count += 1.0;
        if (id == targetId("spleen")) spleen += i.x, spleen_count += 1.0;
    });
    EXPECT_GT(liver / liver_count, spleen / spleen_count + 50.0);
}

TEST_F(ImportReal, FasciaEnclosesLiverAndDucts) {
    const auto& v = imported_->package.labels;
    const Mask outside = test::outsideOf(v, targetId("fascia"));
    std::size_t leaked = 0;
    for (std::size_t i = 0; i < outside.voxels.size(); ++i)
        leaked +=
            outside.voxels[i] && (v.voxels[i] == targetId("liver") || v.voxels[i] == targetId("bile ducts"));
    EXPECT_EQ(leaked, 0u);
}

TEST_F(ImportReal, PlannerFindsPathsInEndExhale) {
    std::size_t good = 0;
    for (const patient::PlannedPath& p : paths())
        good += p.quality >= 0.4;
    EXPECT_GE(good, 20u);
}

// Runs the demo on this patient as a user does. With a GPU it also draws the pictures of the capture points.
TEST_F(ImportReal, DemoHitsADuct) {
#ifdef STYLET_GPU
    const std::string pictures = " --fps 0.01";  // only the pictures of the capture points
#else
    const std::string pictures;
#endif
    const test::Outcome outcome = command_->run("run --headless --fast --scenario demo --patient '" +
                                                packageFolder().string() + "'" + pictures);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(outcome.summary.at("target_hit").get<bool>()) << outcome.out;
    EXPECT_EQ(outcome.summary.at("haptics").at("faults"), 0);
#ifdef STYLET_GPU
    for (const std::string moment : {"approach", "skin", "fascia", "liver", "duct"})
        for (const char* eye : {"_left.png", "_right.png"}) {
            const fs::path file = command_->out() / (moment + eye);
            ASSERT_TRUE(fs::exists(file)) << file;
            EXPECT_GT(fs::file_size(file), 20000u) << file;  // an empty picture is far smaller
        }
#endif
}

}  // namespace
}  // namespace stylet::modeller
