// The verdict of a check lies beside the package. Edits of the verdict or of the package are noticed.
#include "patient/package/verdict.h"

#include <gtest/gtest.h>

#include "base/whole_file.h"
#include "tests/support/file_text.h"
#include "tests/support/phantom.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;

class VerdictTest : public testing::Test {
  protected:
    VerdictTest() { savePackage(package_, folder()); }
    fs::path folder() const { return temp_ / "patient"; }
    fs::path file() const { return folder() / "verdict.json"; }
    void store(bool refused) {
        saveVerdict({digest(package_), refused, {"REFUSED  liver volume: 245 ml"}}, folder());
    }
    // Replaces text in the verdict's file.
    void edit(const std::string& from, const std::string& to) {
        std::string text = test::readText(file());
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << text;
        writeFile(file(), text.replace(at, from.size(), to));
    }
    std::string refusal() const {
        return test::errorText([&] { requirePlausible(package_, folder(), false); });
    }

    test::TempFolder temp_;
    Package package_ = test::makeSlabs({{Tissue::skin, 0.01}, {Tissue::liver, 0.02}}, 0.005);
};

TEST_F(VerdictTest, IsReadBackAsItWasWritten) {
    const CheckVerdict verdict{0xfedcba9876543210u, true, {"a", "b \"quoted\" \\ \xc3\xa9"}};
    saveVerdict(verdict, folder());
    EXPECT_EQ(loadVerdict(folder()), verdict);
    fs::remove(file());
    EXPECT_EQ(loadVerdict(folder()), std::nullopt);
}

TEST_F(VerdictTest, AcceptedPatientIsUsed) {
    store(false);
    EXPECT_EQ(requirePlausible(package_, folder(), false), "");
    EXPECT_EQ(requirePlausible(package_, folder(), true), "");
}

// HZ-TEACH-22
TEST_F(VerdictTest, RefusedPatientNeedsTheInstructor) {
    store(true);
    EXPECT_NE(refusal().find("liver volume: 245 ml"), std::string::npos) << refusal();
    EXPECT_NE(refusal().find("--accept-implausible"), std::string::npos) << refusal();
    const std::string note = requirePlausible(package_, folder(), true);
    EXPECT_EQ(note.rfind("overruled: ", 0), 0u) << note;
    EXPECT_NE(note.find("liver volume: 245 ml"), std::string::npos) << note;
}

TEST_F(VerdictTest, MissingVerdictIsReported) {
    EXPECT_EQ(requirePlausible(package_, folder(), false), kNotChecked);
    EXPECT_EQ(requirePlausible(package_, folder(), true), kNotChecked);
}

// HZ-TEACH-22
TEST_F(VerdictTest, EditedVerdictIsRefused) {
    for (const bool refused : {true, false}) {
        store(refused);
        edit(refused ? "true" : "false", refused ? "false" : "true");
        EXPECT_NE(refusal().find("checksum"), std::string::npos) << refusal();
    }
    store(true);
    edit("245 ml", "1245 ml");
    EXPECT_NE(refusal().find("checksum"), std::string::npos) << refusal();
    EXPECT_NE(requirePlausible(package_, folder(), true).find("checksum"), std::string::npos);
}

// HZ-TEACH-22
TEST_F(VerdictTest, PatientChangedAfterItsCheckIsRefused) {
    store(false);
    Package changed = package_;
    changed.labels.voxels[changed.labels.voxels.size() / 2] ^= 1u;
    EXPECT_THROW(requirePlausible(changed, folder(), false), DataError);
    EXPECT_NE(requirePlausible(changed, folder(), true).find("changed after its check"), std::string::npos);
    changed = package_;
    changed.tissues[0].cut_force_n += 0.5;
    EXPECT_THROW(requirePlausible(changed, folder(), false), DataError);
    // A verdict copied from another patient.
    saveVerdict({digest(changed), false, {}}, folder());
    EXPECT_NE(refusal().find("changed after its check"), std::string::npos) << refusal();
}

TEST_F(VerdictTest, SavingThePackageRemovesTheVerdict) {
    store(false);
    savePackage(package_, folder());
    EXPECT_FALSE(fs::exists(file()));
}

TEST_F(VerdictTest, DamagedFilesAreRefused) {
    store(false);
    const std::string sound = test::readText(file());
    for (const std::string& text :
         {std::string(), std::string("{}"), std::string("[1]"), sound.substr(0, sound.size() / 2),
          sound + "x", std::string(2 << 20, ' ')}) {
        writeFile(file(), text);
        EXPECT_THROW(loadVerdict(folder()), DataError) << text.substr(0, 40);
    }
    writeFile(file(), sound);
    edit("stylet verdict 1", "stylet verdict 2");
    EXPECT_NE(refusal().find("format"), std::string::npos) << refusal();
    writeFile(file(), sound);
    edit("\"refused\"", "\"unknown\": 1, \"refused\"");
    EXPECT_NE(refusal().find("unknown"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace stylet::patient
