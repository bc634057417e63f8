#include "patient/package/package.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>

#include "patient/package/motion_io.h"
#include "patient/package/nifti.h"
#include "patient/package/origin.h"
#include "tests/support/file_text.h"
#include "tests/support/motion.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;
using test::expectRefused;
using test::readText;

// A package with every field set, and a spacing that single precision cannot represent.
Package fullPackage() {
    Package p =
        test::makeSlabs({{Tissue::skin, 0.0021}, {Tissue::liver, 0.0077}, {Tissue::duct, 0.0035}}, 0.0007);
    p.name = "slabs \"of\" a \\ test\tünder\n\x01";
    p.atlases = {"reference patient, seed 11", "a \"name\", \\ and\n\x01"};
    Label& soft = p.label_table[1];
    soft.structure = Structure::small_bowel, soft.drains_ducts = true;
    Label& liver = p.label_table[4];
    liver.structure = Structure::tumour, liver.blocks_contrast = true;
    liver.border_uncertainty_m = 0.1 / 70.0;
    p.reference_phase = "v=0.35";
    p.motion = test::makeTurningBall(0.05, 0.3, 0.011);
    p.motion.grid.spacing_m.x = 0.011 + 1e-9;  // not representable in single precision either
    p.motion.slide[700].a2_m_s[1] = 1.0f / 3000.0f;
    p.motion.reference = {0.35, 0.0};
    p.motion.v = {-1.0 / 3.0, 1.2};
    p.motion.rate_per_s = {-2.5, 3.5};
    p.signal = {10.0 / 3.0, 0.9};
    p.scan = {0.01 / 3.0, 0.0007};
    return p;
}

bool sameTable(const std::vector<Label>& a, const std::vector<Label>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Label& x, const Label& y) {
        return x.id == y.id && x.name == y.name && x.tissue == y.tissue && x.role == y.role &&
               x.abdominal == y.abdominal && x.blood == y.blood && x.structure == y.structure &&
               x.blocks_contrast == y.blocks_contrast && x.drains_ducts == y.drains_ducts &&
               x.colour == y.colour && x.provenance == y.provenance &&
               x.border_uncertainty_m == y.border_uncertainty_m;
    });
}

// A saved package, so that a test can damage its patient.toml.
class SavedPackage : public ::testing::Test {
  protected:
    SavedPackage() {
        savePackage(fullPackage(), folder_);
        toml_ = readText(folder_ / "patient.toml");
    }
    void writeToml(const std::string& text) {
        std::ofstream(folder_ / "patient.toml", std::ios::binary) << text;
    }
    void expectLoadRefused(const std::string& file, const std::string& field) {
        expectRefused([&] { loadPackage(folder_); }, file, field);
    }
    void expectTomlRefused(const std::string& text, const std::string& field) {
        writeToml(text);
        expectLoadRefused("patient.toml", field);
    }
    void expectRefusedWith(const std::string& from, const std::string& to, const std::string& field) {
        const std::size_t at = toml_.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        expectTomlRefused(std::string(toml_).replace(at, from.size(), to), field);
    }

    test::TempFolder temp_;
    fs::path folder_ = temp_ / "patient";
    std::string toml_;
};

TEST_F(SavedPackage, RoundTripsUnchanged) {
    const Package p = fullPackage(), back = loadPackage(folder_);
    EXPECT_EQ(back.name, p.name);
    EXPECT_EQ(back.licence, p.licence);
    EXPECT_EQ(back.provenance, p.provenance);
    EXPECT_EQ(back.atlases, p.atlases);
    EXPECT_EQ(back.reference_phase, p.reference_phase);
    EXPECT_EQ(back.scan.slice_m, p.scan.slice_m);
    EXPECT_EQ(back.scan.blur_within_m, p.scan.blur_within_m);
    EXPECT_EQ(back.ct.grid, p.ct.grid);
    EXPECT_EQ(back.labels.grid, p.labels.grid);
    EXPECT_EQ(back.ct.voxels, p.ct.voxels);
    EXPECT_EQ(back.labels.voxels, p.labels.voxels);
    EXPECT_EQ(back.tissues, p.tissues);
    EXPECT_EQ(back.elasticity, p.elasticity);
    EXPECT_EQ(back.thresholds, p.thresholds);
    EXPECT_EQ(back.motion, p.motion);
    EXPECT_EQ(back.signal, p.signal);
    EXPECT_TRUE(sameTable(back.label_table, p.label_table));
    EXPECT_EQ(digest(back), digest(p));
}

TEST_F(SavedPackage, SavingTwiceGivesTheSameBytes) {
    savePackage(loadPackage(folder_), temp_ / "again");
    for (const char* name : {"patient.toml", "ct.nii.gz", "labels.nii.gz", "labels.ctbl"})
        EXPECT_EQ(test::fileBytes(folder_ / name), test::fileBytes(temp_ / "again" / name)) << name;
}

// HZ-RECORD-13
TEST_F(SavedPackage, IsReplacedWholeAndLeavesNothingBehind) {
    std::ofstream(folder_ / "paths.json") << "[]";
    Package p = fullPackage();
    p.name = "another";
    savePackage(p, folder_);
    EXPECT_EQ(loadPackage(folder_).name, "another");
    EXPECT_FALSE(fs::exists(folder_ / "paths.json"));
    EXPECT_EQ(std::distance(fs::directory_iterator(temp_.path()), fs::directory_iterator()), 1);
}

TEST_F(SavedPackage, ColourTableIsWhatSlicerReads) {
    std::istringstream in(readText(folder_ / "labels.ctbl"));
    std::string line;
    int entries = 0;
    while (std::getline(in, line)) {
        if (line.starts_with('#')) continue;
        std::istringstream fields(line);
        int id = -1, r = -1, g = -1, b = -1, a = -1;
        std::string name, rest;
        fields >> id >> name >> r >> g >> b >> a;
        EXPECT_TRUE(fields && !(fields >> rest)) << line;
        EXPECT_EQ(id, entries++);
    }
    EXPECT_EQ(entries, 9);
}

TEST_F(SavedPackage, TomlTruncatedAtAnyLine) {
    for (std::size_t at = toml_.find('\n'); at != std::string::npos; at = toml_.find('\n', at + 1)) {
        const std::string head = toml_.substr(0, at);
        if (at + 1 == toml_.size()) continue;
        writeToml(head);
        EXPECT_THROW(loadPackage(folder_), DataError) << head;
    }
}

// An exact border is not written: packages of older programs have the same bytes.
TEST_F(SavedPackage, ExactBordersAreNotWritten) {
    const std::string text = readText(folder_ / "patient.toml");
    const std::size_t first = text.find("border_uncertainty_m");
    EXPECT_NE(first, std::string::npos);
    EXPECT_EQ(text.find("border_uncertainty_m", first + 1), std::string::npos);
}

TEST_F(SavedPackage, UnknownKeysAreNamed) {
    expectTomlRefused("colour_of_eyes = 3\n" + toml_, "colour_of_eyes: unknown key");
    expectRefusedWith("[breathing]", "[breathing]\nswallows = true", "breathing.swallows: unknown key");
    expectRefusedWith("[thresholds]", "[thresholds]\nt3_hu = 1", "thresholds.t3_hu: unknown key");
    expectRefusedWith("[[label]]", "[[label]]\nsize = 1", "label[0].size: unknown key");
    expectRefusedWith("[[tissue]]", "[[tissue]]\nsize = 1", "tissue[0].size: unknown key");
}

TEST_F(SavedPackage, BadValuesAreNamed) {
    expectRefusedWith("stylet patient 5", "stylet patient 6", "format: not");
    expectRefusedWith("v=0.35", "v=nan", "reference_phase");
    expectRefusedWith("v=0.35", "v=-1", "reference_phase");
    expectRefusedWith("v=0.35", "v=0.3 ", "reference_phase");
    expectRefusedWith("v=0.35", "asleep", "reference_phase");
    expectRefusedWith("t0_hu = -500.0", "t0_hu = nan", "thresholds.t0_hu");
    expectRefusedWith("t0_hu = -500.0", "t0_hu = -100.0", "thresholds.t1_hu");
    expectRefusedWith("t2_specific_hu = 300", "t2_specific_hu = 100", "thresholds.t2_specific_hu");
    expectRefusedWith("cut_force_n = 0.7", "cut_force_n = -0.7", "tissue[1].cut_force_n");
    expectRefusedWith("cut_force_n = 0.7", "cut_force_n = nan", "tissue[1].cut_force_n");
    expectRefusedWith("friction_n = 0.7", "friction_n = inf", "tissue[1].friction_n");
    expectRefusedWith("stiffness_n_per_m = 800.0", "stiffness_n_per_m = 0", "tissue[1].stiffness_n_per_m");
    expectRefusedWith("name = \"skin\"", "name = \"air\"", "tissue[1].name");
    expectRefusedWith("name = \"skin\"", "name = \"hair\"", "tissue[1].name");
    expectRefusedWith("role = \"pass\"", "role = \"fail\"", "tissue[0].role");
    expectRefusedWith("membrane = true", "membrane = 1", "tissue[1].membrane");
    expectRefusedWith("young_pa = 70000.0", "young_pa = 7.0", "tissue[1].young_pa");
    expectRefusedWith("young_pa = 70000.0", "young_pa = nan", "tissue[1].young_pa");
    expectRefusedWith("young_pa = 70000.0", "", "tissue[1].young_pa: missing");
    expectRefusedWith("young_source", "young_book", "tissue[0].young_source: missing");
    expectRefusedWith("id = 2", "id = 1", "label[1].id");
    expectRefusedWith("id = 2", "id = 0", "label[1].id");
    expectRefusedWith("id = 2", "id = 256", "label[1].id");
    expectRefusedWith("id = 2", "id = 2.0", "label[1].id");
    expectRefusedWith("colour = [30", "colour = [300", "label[0].colour");
    expectRefusedWith("colour = [30", "colour = [3, 3", "label[0].colour");
    const char* const border = "border_uncertainty_m = 0.0014285714285714286";
    expectRefusedWith(border, "border_uncertainty_m = nan", "label[4].border_uncertainty_m");
    expectRefusedWith(border, "border_uncertainty_m = -0.001", "label[4].border_uncertainty_m");
    expectRefusedWith(border, "border_uncertainty_m = 1.5", "label[4].border_uncertainty_m");
    expectRefusedWith("spacing_m = [7e-04", "spacing_m = [nan", "grid.spacing_m");
    expectRefusedWith("spacing_m = [7e-04", "spacing_m = [-7e-04", "grid.spacing_m");
    expectRefusedWith("licence = \"CC0-1.0\"", "licence = 5", "licence");
}

TEST_F(SavedPackage, BadBreathingIsNamed) {
    expectRefusedWith("period_s = 3", "period_s = -3", "breathing.period_s");
    expectRefusedWith("amplitude = 0.9", "amplitude = 9", "breathing.amplitude");
    expectRefusedWith("v_low = -0.3", "v_low = 1.3", "breathing.v_high: not above v_low");
    expectRefusedWith("v_high = 1.2", "v_high = 12.0", "breathing.v_high");
    expectRefusedWith("rate_high_per_s = 3.5", "rate_high_per_s = nan", "breathing.rate_high_per_s");
    expectRefusedWith("dome_travel_m = 0.0", "dome_travel_m = 7.0", "breathing.dome_travel_m");
}

TEST_F(SavedPackage, OlderFormatsAreRejectedWithAReason) {
    expectRefusedWith("stylet patient 5", "stylet patient 4",
                      "format: an older patient, in which cartilage is bone");
    expectRefusedWith("stylet patient 5", "stylet patient 3",
                      "format: an older patient, whose labels have no roles (blood, structure, ...): make, "
                      "import or build it again");
    expectRefusedWith("stylet patient 5", "stylet patient 2",
                      "format: an older patient, whose tissues have no elasticity");
    expectRefusedWith("stylet patient 5", "stylet patient 1", "format: an older format");
}

TEST_F(SavedPackage, BadRolesAreNamed) {
    expectRefusedWith("blood = \"other\"", "blood = \"blue\"", "label[5].blood");
    expectRefusedWith("blood = \"other\"", "blood = \"Portal\"", "label[5].blood");
    expectRefusedWith("blood = \"other\"", "blood = \"\"", "label[5].blood");
    expectRefusedWith("blood = \"other\"", "blood = 1", "label[5].blood");
    expectRefusedWith("blood = \"other\"\n", "", "label[5].blood: missing");
    expectRefusedWith("structure = \"tumour\"", "structure = \"tumor\"", "label[4].structure");
    expectRefusedWith("structure = \"tumour\"\n", "", "label[4].structure: missing");
    expectRefusedWith("blocks_contrast = true", "blocks_contrast = \"true\"", "label[4].blocks_contrast");
    expectRefusedWith("blocks_contrast = true\n", "", "label[4].blocks_contrast: missing");
    expectRefusedWith("drains_ducts = true", "drains_ducts = 1", "label[1].drains_ducts");
    expectRefusedWith("drains_ducts = true\n", "", "label[1].drains_ducts: missing");
    expectRefusedWith("atlases = [", "atlases = [3, ", "atlases");
    expectRefusedWith("atlases = [", "atlas = [", "atlases: missing");
    expectRefusedWith("slice_m = ", "slice_m = -", "scan.slice_m");
    expectRefusedWith("blur_within_m = ", "blur_m = ", "scan.blur_m");
    expectRefusedWith("atlases = [", "atlases = [\"" + std::string(300, 'x') + "\", ", "atlases");
}

// Each case passes the checks of its single fields.
TEST_F(SavedPackage, ContradictoryRolesAreNamed) {
    expectRefusedWith("blood = \"other\"", "blood = \"none\"", "label[5].blood: \"none\" in a vessel");
    expectRefusedWith("blood = \"none\"", "blood = \"portal\"", "label[0].blood: flows, but the tissue");
    expectRefusedWith("blood = \"other\"\nstructure = \"other\"", "blood = \"other\"\nstructure = \"heart\"",
                      "label[5].blood: flows in the heart");
    expectRefusedWith("structure = \"tumour\"", "structure = \"heart\"", "label[4].structure: the heart");
    expectRefusedWith("structure = \"tumour\"", "structure = \"cartilage\"", "label[4].structure: cartilage");
    expectRefusedWith("structure = \"tumour\"", "structure = \"lung\"", "label[4].structure: lung or gas");
    expectRefusedWith("structure = \"small_bowel\"", "structure = \"gas\"",
                      "label[1].structure: lung or gas");
    expectRefusedWith("blocks_contrast = true\ndrains_ducts = false",
                      "blocks_contrast = false\ndrains_ducts = true", "label[4].drains_ducts: true, but");
    expectRefusedWith("blocks_contrast = false\ndrains_ducts = true",
                      "blocks_contrast = true\ndrains_ducts = true",
                      "label[1].drains_ducts: true for a label that blocks");
    Package p = fullPackage();
    p.label_table[6].blocks_contrast = true;
    expectRefused([&] { savePackage(p, temp_ / "never"); }, "patient.toml",
                  "label[6].blocks_contrast: true for a duct that is a target");
    p.label_table[6].role = Role::pass;
    savePackage(p, temp_ / "closed");
    EXPECT_TRUE(loadPackage(temp_ / "closed").label_table[6].blocks_contrast);
}

// Damages motion.nii.gz in several ways. The loader's error must name the reason.
TEST_F(SavedPackage, BadMotionIsNamed) {
    const auto expectMotionRefused = [&](const auto& spoil, const std::string& reason) {
        MotionModel m = fullPackage().motion;
        spoil(m);
        writeMotion(folder_ / "motion.nii.gz", m);
        expectLoadRefused("motion.nii.gz", reason);
    };
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    expectMotionRefused([](MotionModel& m) { m.slide[700].a1_m[2] = kNaN; }, "voxels: ");
    expectMotionRefused([](MotionModel& m) { m.level_m[3] = kNaN; }, "voxels: ");
    expectMotionRefused([](MotionModel& m) { m.wall[700].a2_m_s[0] = 0.2f; },
                        "voxels: a motion beyond 100 mm");
    expectMotionRefused([](MotionModel& m) { m.level_m[3] = 2.0f; }, "voxels: a level beyond 1 m");
    expectMotionRefused([](MotionModel& m) { m.wall[1].a1_m[0] = 0.001f; }, "voxels: the field does not end");
    expectMotionRefused([](MotionModel& m) { m.slide[700].a1_m[0] = 0.09f; }, "voxels: a field is too steep");
    expectMotionRefused([](MotionModel& m) { m.grid.spacing_m.y *= 1.1; }, "spacing: differs");
    expectMotionRefused([](MotionModel& m) { m.grid.origin_m.z += 0.001; }, "origin: differs");
    expectMotionRefused(
        [](MotionModel& m) {
            m = test::makeMotion(Vec3(0.011), 0.011, [](const Vec3&) { return test::MotionPoint{}; });
            m.grid.dims.x = 2;
            for (auto* field : {&m.wall, &m.slide})
                field->resize(m.grid.voxelCount());
            m.level_m.resize(m.grid.voxelCount());
            m.grid.spacing_m.x += 1e-9;
            m.grid.origin_m = fullPackage().motion.grid.origin_m;
        },
        "dim: fewer than three nodes");
    std::filesystem::remove(folder_ / "motion.nii.gz");
    expectLoadRefused("motion.nii.gz", "file: cannot be opened");
}

// The scalar loader rejects the header of a vector volume, and the vector loader rejects that of a scalar
// volume.
TEST_F(SavedPackage, MotionMustBeAVectorVolume) {
    fs::copy_file(folder_ / "ct.nii.gz", folder_ / "motion.nii.gz", fs::copy_options::overwrite_existing);
    expectLoadRefused("motion.nii.gz", "dim[5]");
    savePackage(fullPackage(), folder_);
    fs::copy_file(folder_ / "motion.nii.gz", folder_ / "ct.nii.gz", fs::copy_options::overwrite_existing);
    expectLoadRefused("ct.nii.gz", "dim[5]");
}

TEST_F(SavedPackage, WithoutMotionThereIsNoFile) {
    Package p = fullPackage();
    p.motion.grid = {};
    p.motion.wall.clear(), p.motion.slide.clear(), p.motion.level_m.clear();
    savePackage(p, folder_);
    EXPECT_FALSE(fs::exists(folder_ / "motion.nii.gz"));
    EXPECT_TRUE(loadPackage(folder_).motion.empty());
}

TEST_F(SavedPackage, InvalidMotionIsNotSaved) {
    Package p = fullPackage();
    p.motion.slide[700].a1_m[0] = 0.09f;
    expectRefused([&] { savePackage(p, folder_); }, "motion.nii.gz", "voxels: a field is too steep");
    EXPECT_EQ(loadPackage(folder_).motion, fullPackage().motion);
}

TEST_F(SavedPackage, InvalidTomlIsRejected) {
    expectTomlRefused("", "format: missing");
    expectTomlRefused("[[[", "line 1");
    expectTomlRefused("format = \"\xff\xfe\"", "line 1");
    expectTomlRefused(std::string(2 << 20, ' '), "file");
    expectTomlRefused("a = " + std::string(5000, '['), "line 1");
    fs::remove(folder_ / "patient.toml");
    expectLoadRefused("patient.toml", "file");
}

TEST_F(SavedPackage, VolumesMustAgree) {
    const Package good = fullPackage();
    LabelVolume labels = good.labels;
    labels.grid.origin_m.x += 0.001;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectLoadRefused("labels.nii.gz", "origin");
    labels = good.labels;
    labels.grid.spacing_m.y *= 1.1;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectLoadRefused("labels.nii.gz", "spacing");
    Grid shorter = good.labels.grid;
    --shorter.dims.z;
    writeNifti(folder_ / "labels.nii.gz", LabelVolume(shorter));
    expectLoadRefused("labels.nii.gz", "dim");
    labels = good.labels;
    labels.voxels[17] = 99;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectLoadRefused("labels.nii.gz", "voxels: id 99");
}

TEST(SavePackage, RejectsPackagesThatWouldNotLoad) {
    const test::TempFolder temp;
    Package p = fullPackage();
    p.reference_phase = "inhale";
    expectRefused([&] { savePackage(p, temp / "a"); }, "patient.toml", "reference_phase");
    p = fullPackage();
    p.tissues[3].friction_n = std::nan("");
    expectRefused([&] { savePackage(p, temp / "a"); }, "patient.toml", "tissue[3].friction_n");
    p = fullPackage();
    p.labels.voxels[0] = 200;
    expectRefused([&] { savePackage(p, temp / "a"); }, "labels.nii.gz", "voxels");
    EXPECT_TRUE(fs::is_empty(temp.path()));
}

// HZ-RECORD-13
TEST(SavePackage, DoesNotOverwriteForeignFolders) {
    const test::TempFolder temp;
    fs::create_directory(temp / "photos");
    std::ofstream(temp / "photos" / "cat.jpg") << "meow";
    expectRefused([&] { savePackage(fullPackage(), temp / "photos"); }, "photos", "folder");
    EXPECT_TRUE(fs::exists(temp / "photos" / "cat.jpg"));
}

// HZ-TEACH-07
TEST(Digest, CoversEverythingThatForcesDependOn) {
    const Package good = fullPackage();
    std::vector<std::uint64_t> digests{digest(good)};
    const auto with = [&](auto change) {
        Package p = good;
        change(p);
        digests.push_back(digest(p));
    };
    with([](Package& p) { p.tissues[4].friction_n += 1e-12; });
    with([](Package& p) { p.tissues[0].membrane = true; });
    with([](Package& p) { p.elasticity[2].young_pa += 1e-9; });
    with([](Package& p) { p.thresholds.t2_specific_hu += 1; });
    with([](Package& p) { p.label_table[0].tissue = Tissue::bone; });
    with([](Package& p) { p.label_table[0].abdominal = true; });
    with([](Package& p) { p.label_table.pop_back(); });
    with([](Package& p) { p.labels.voxels.back() = 1; });
    with([](Package& p) { p.label_table[5].blood = BloodKind::portal; });
    with([](Package& p) { p.label_table[4].blocks_contrast = false; });
    with([](Package& p) { p.label_table[1].drains_ducts = false; });
    with([](Package& p) { p.label_table[4].border_uncertainty_m = 0.0; });
    with([](Package& p) { p.label_table[3].border_uncertainty_m = 0.001; });
    with([](Package& p) { p.ct.voxels[3] = 1; });
    with([](Package& p) { p.ct.grid.origin_m.x += 1e-9; });
    with([](Package& p) { p.motion.wall[700].a1_m[0] += 1e-9f; });
    with([](Package& p) { p.motion.slide[700].a2_m_s[2] += 1e-9f; });
    with([](Package& p) { p.motion.level_m[700] += 1e-6f; });
    with([](Package& p) { p.motion.v.high = 1.3; });
    with([](Package& p) { p.motion.reference.v = 0.0; });
    with([](Package& p) { p.signal.period_s = 5.0; });
    std::sort(digests.begin(), digests.end());
    EXPECT_EQ(std::unique(digests.begin(), digests.end()), digests.end());
}

TEST(Digest, IgnoresNamesAndOrder) {
    const Package good = fullPackage();
    Package p = good;
    p.name = "x", p.licence = "y", p.atlases.clear(), p.label_table[2].name = "z",
    p.label_table[2].colour = {1, 2, 3};
    std::reverse(p.label_table.begin(), p.label_table.end());
    EXPECT_EQ(digest(p), digest(good));
}

// The atlases are named in one place. The text for people is made from it.
TEST(Package, ItsOriginNamesItsVariants) {
    EXPECT_EQ(synthVariants("synthetic: made by stylet-model synth --seed 3"), "");
    EXPECT_EQ(synthVariants("synthetic: made by stylet-model synth --seed 3 --variant native,noise-x2"),
              "native,noise-x2");
    EXPECT_EQ(synthVariants("made with --variant stent; atlases: \"A\""), "stent");
}

TEST(Package, ItsOriginNamesItsAtlases) {
    Package p;
    p.provenance = "built";
    EXPECT_EQ(describeOrigin(p), "built");
    EXPECT_EQ(formatAtlasList(p.atlases), "");
    p.atlases = {"A", "B"};
    EXPECT_EQ(describeOrigin(p), "built; atlases: \"A\", \"B\"");
    EXPECT_EQ(formatAtlasList({"A\nB\033[31m\x7f"}), "atlases: \"A B [31m \"");
}

}  // namespace
}  // namespace stylet::patient
