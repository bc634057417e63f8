#include "patient/package.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "patient/nifti.h"
#include "tests/support/nifti_bytes.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;
using test::expectRefused;

// Everything set, and a spacing that single precision cannot hold.
Package fullPackage() {
    Package p =
        test::makeSlabs({{Tissue::skin, 0.0021}, {Tissue::liver, 0.0077}, {Tissue::duct, 0.0035}}, 0.0007);
    p.name = "slabs \"of\" a \\ test\tünder\n\x01";
    p.reference_phase = "v=0.35";
    BreathingModel& m = p.breathing;
    m.a1_m = -0.02, m.a2_m_s = 0.001, m.outside_share = 0.1 + 0.2;
    m.z_low_m = -0.15, m.z_full_low_m = -0.08, m.z_full_high_m = 0.06, m.z_high_m = 0.13;
    m.cavity = {{-0.16, 0, 0.01, 0.13, 0.10}, {0.05, 1e-9, 0, 0.12, 0.09}, {0.14, 0, 0, 0.03, 1.0 / 30}};
    m.reference = {0.35, 0.0};
    m.signal = {10.0 / 3.0, 0.9};
    return p;
}

bool sameTable(const std::vector<Label>& a, const std::vector<Label>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Label& x, const Label& y) {
        return x.id == y.id && x.name == y.name && x.tissue == y.tissue && x.role == y.role &&
               x.abdominal == y.abdominal && x.colour == y.colour && x.provenance == y.provenance;
    });
}

std::string textOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

// A saved package whose patient.toml is then spoiled.
class SavedPackage : public ::testing::Test {
  protected:
    SavedPackage() {
        savePackage(fullPackage(), folder_);
        toml_ = textOf(folder_ / "patient.toml");
    }
    void writeToml(const std::string& text) {
        std::ofstream(folder_ / "patient.toml", std::ios::binary) << text;
    }
    void expectTomlRefused(const std::string& text, const std::string& field) {
        writeToml(text);
        expectRefused([&] { loadPackage(folder_); }, "patient.toml", field);
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

TEST_F(SavedPackage, ComesBackEqual) {
    const Package p = fullPackage(), back = loadPackage(folder_);
    EXPECT_EQ(back.name, p.name);
    EXPECT_EQ(back.licence, p.licence);
    EXPECT_EQ(back.provenance, p.provenance);
    EXPECT_EQ(back.reference_phase, p.reference_phase);
    EXPECT_EQ(back.ct.grid, p.ct.grid);
    EXPECT_EQ(back.labels.grid, p.labels.grid);
    EXPECT_EQ(back.ct.voxels, p.ct.voxels);
    EXPECT_EQ(back.labels.voxels, p.labels.voxels);
    EXPECT_EQ(back.tissues, p.tissues);
    EXPECT_EQ(back.thresholds, p.thresholds);
    EXPECT_EQ(back.breathing, p.breathing);
    EXPECT_TRUE(sameTable(back.label_table, p.label_table));
    EXPECT_EQ(digest(back), digest(p));
}

TEST_F(SavedPackage, SameBytesAgain) {
    savePackage(loadPackage(folder_), temp_ / "again");
    for (const char* name : {"patient.toml", "ct.nii.gz", "labels.nii.gz", "labels.ctbl"})
        EXPECT_EQ(test::fileBytes(folder_ / name), test::fileBytes(temp_ / "again" / name)) << name;
}

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
    std::istringstream in(textOf(folder_ / "labels.ctbl"));
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
    EXPECT_EQ(entries, 8);
}

TEST_F(SavedPackage, TomlTruncatedAtAnyLine) {
    for (std::size_t at = toml_.find('\n'); at != std::string::npos; at = toml_.find('\n', at + 1)) {
        const std::string head = toml_.substr(0, at);
        if (at + 1 == toml_.size()) continue;
        writeToml(head);
        EXPECT_THROW(loadPackage(folder_), DataError) << head;
    }
}

TEST_F(SavedPackage, UnknownKeysAreNamed) {
    expectTomlRefused("colour_of_eyes = 3\n" + toml_, "colour_of_eyes: unknown key");
    expectRefusedWith("[breathing]", "[breathing]\nswallows = true", "breathing.swallows: unknown key");
    expectRefusedWith("[thresholds]", "[thresholds]\nt3_hu = 1", "thresholds.t3_hu: unknown key");
    expectRefusedWith("[[label]]", "[[label]]\nsize = 1", "label[0].size: unknown key");
    expectRefusedWith("[[tissue]]", "[[tissue]]\nsize = 1", "tissue[0].size: unknown key");
}

TEST_F(SavedPackage, BadValuesAreNamed) {
    expectRefusedWith("stylet patient 1", "stylet patient 2", "format");
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
    expectRefusedWith("id = 2", "id = 1", "label[1].id");
    expectRefusedWith("id = 2", "id = 0", "label[1].id");
    expectRefusedWith("id = 2", "id = 256", "label[1].id");
    expectRefusedWith("id = 2", "id = 2.0", "label[1].id");
    expectRefusedWith("colour = [30", "colour = [300", "label[0].colour");
    expectRefusedWith("colour = [30", "colour = [3, 3", "label[0].colour");
    expectRefusedWith("spacing_m = [7e-04", "spacing_m = [nan", "grid.spacing_m");
    expectRefusedWith("spacing_m = [7e-04", "spacing_m = [-7e-04", "grid.spacing_m");
    expectRefusedWith("licence = \"CC0-1.0\"", "licence = 5", "licence");
}

TEST_F(SavedPackage, BadBreathingIsNamed) {
    expectRefusedWith("a1_m = -0.02", "a1_m = -2", "breathing.a1_m");
    expectRefusedWith("a1_m = -0.02", "a1_m = -0.1", "breathing.a1_m: the motion falls off too steeply");
    expectRefusedWith("z_full_low_m = -0.08", "z_full_low_m = 0.07", "breathing.z_low_m");
    expectRefusedWith("z_high_m = 0.13", "z_high_m = 0.15", "breathing.cavity");
    expectRefusedWith("[0.05, 1e-09", "[-0.2, 1e-09", "breathing.cavity");
    expectRefusedWith("0.12, 0.09]", "0.12, 0.0]", "breathing.cavity");
    expectRefusedWith("0.12, 0.09]", "0.12]", "breathing.cavity");
    expectRefusedWith("0.12, 0.09]", "0.12, inf]", "breathing.cavity");
    expectRefusedWith("period_s = 3", "period_s = -3", "breathing.period_s");
}

TEST_F(SavedPackage, TomlThatIsNone) {
    expectTomlRefused("", "format: missing");
    expectTomlRefused("[[[", "line 1");
    expectTomlRefused("format = \"\xff\xfe\"", "line 1");
    expectTomlRefused(std::string(2 << 20, ' '), "file");
    expectTomlRefused("a = " + std::string(5000, '['), "line 1");
    fs::remove(folder_ / "patient.toml");
    expectRefused([&] { loadPackage(folder_); }, "patient.toml", "file");
}

TEST_F(SavedPackage, VolumesMustAgree) {
    const Package good = fullPackage();
    LabelVolume labels = good.labels;
    labels.grid.origin_m.x += 0.001;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectRefused([&] { loadPackage(folder_); }, "labels.nii.gz", "origin");
    labels = good.labels;
    labels.grid.spacing_m.y *= 1.1;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectRefused([&] { loadPackage(folder_); }, "labels.nii.gz", "spacing");
    Grid shorter = good.labels.grid;
    --shorter.dims.z;
    writeNifti(folder_ / "labels.nii.gz", LabelVolume(shorter));
    expectRefused([&] { loadPackage(folder_); }, "labels.nii.gz", "dim");
    labels = good.labels;
    labels.voxels[17] = 99;
    writeNifti(folder_ / "labels.nii.gz", labels);
    expectRefused([&] { loadPackage(folder_); }, "labels.nii.gz", "voxels: id 99");
}

TEST(SavePackage, RefusesWhatCouldNotBeLoaded) {
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

TEST(SavePackage, SparesForeignFolders) {
    const test::TempFolder temp;
    fs::create_directory(temp / "photos");
    std::ofstream(temp / "photos" / "cat.jpg") << "meow";
    expectRefused([&] { savePackage(fullPackage(), temp / "photos"); }, "photos", "folder");
    EXPECT_TRUE(fs::exists(temp / "photos" / "cat.jpg"));
}

TEST(Digest, CoversWhatForcesDependOn) {
    const Package good = fullPackage();
    std::vector<std::uint64_t> digests{digest(good)};
    const auto with = [&](auto change) {
        Package p = good;
        change(p);
        digests.push_back(digest(p));
    };
    with([](Package& p) { p.tissues[4].friction_n += 1e-12; });
    with([](Package& p) { p.tissues[0].membrane = true; });
    with([](Package& p) { p.thresholds.t2_specific_hu += 1; });
    with([](Package& p) { p.label_table[0].tissue = Tissue::bone; });
    with([](Package& p) { p.label_table[0].abdominal = true; });
    with([](Package& p) { p.label_table.pop_back(); });
    with([](Package& p) { p.labels.voxels.back() = 1; });
    with([](Package& p) { p.ct.voxels[3] = 1; });
    with([](Package& p) { p.ct.grid.origin_m.x += 1e-9; });
    with([](Package& p) { p.breathing.cavity[1].rx_m += 1e-9; });
    with([](Package& p) { p.breathing.reference.v = 0.0; });
    with([](Package& p) { p.breathing.signal.period_s = 5.0; });
    std::sort(digests.begin(), digests.end());
    EXPECT_EQ(std::unique(digests.begin(), digests.end()), digests.end());
}

TEST(Digest, IsBlindToNamesAndOrder) {
    const Package good = fullPackage();
    Package p = good;
    p.name = "x", p.licence = "y", p.label_table[2].name = "z", p.label_table[2].colour = {1, 2, 3};
    std::reverse(p.label_table.begin(), p.label_table.end());
    EXPECT_EQ(digest(p), digest(good));
}

}  // namespace
}  // namespace stylet::patient
