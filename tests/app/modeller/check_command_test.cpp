// Runs `stylet-model check PACKAGE` as a user does. Status 0: plausible, 1: refused, 2: cannot be read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "patient/synth/labels.h"
#include "patient/synth/synth.h"
#include "tests/support/phantom.h"
#include "tests/support/temp_folder.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using patient::Package;
using patient::synth::Id;

// A package without a gas label: gas is left to the thresholds.
Package somebody() {
    patient::synth::SynthSettings s;
    s.seed = 1;
    s.spacing_m = 0.003;
    s.defaults = test::tissueDefaults();
    Package p = patient::synth::makeReferencePatient(s);
    std::replace(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::gas), std::uint8_t(0));
    p.label_table.pop_back();
    return p;
}

struct Said {
    int status = -1;
    std::string out, err;
};

Said check(const fs::path& package, const fs::path& temp) {
    const auto text = [](const fs::path& file) {
        std::ifstream in(file);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const std::string line = "'" + std::string(std::getenv("STYLET_BIN")) + "/stylet-model' check '" +
                             package.string() + "' >'" + (temp / "out").string() + "' 2>'" +
                             (temp / "err").string() + "'";
    const int status = WEXITSTATUS(std::system(line.c_str()));
    return {status, text(temp / "out"), text(temp / "err")};
}

TEST(CheckCommand, SaysWhatIsImplausible) {
    const test::TempFolder temp;
    Package p = somebody();
    patient::savePackage(p, temp / "patient");
    const Said plausible = check(temp / "patient", temp.path());
    EXPECT_EQ(plausible.status, 0) << plausible.out;
    EXPECT_NE(plausible.out.find("look     voxel size in x: 3 mm, expected 0.3 to 2.5 mm"), std::string::npos)
        << plausible.out;
    EXPECT_EQ(plausible.out.find("REFUSED"), std::string::npos) << plausible.out;

    std::replace(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::skin),
                 std::uint8_t(Id::fat));
    patient::savePackage(p, temp / "patient");
    const Said refused = check(temp / "patient", temp.path());
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(refused.out.rfind("REFUSED  skin: 0 ml, expected at least", 0), 0u) << refused.out;

    fs::remove(temp / "patient" / "labels.nii.gz");
    const Said damaged = check(temp / "patient", temp.path());
    EXPECT_EQ(damaged.status, 2);
    EXPECT_NE(damaged.err.find("labels.nii.gz"), std::string::npos) << damaged.err;
}

}  // namespace
}  // namespace stylet::modeller
