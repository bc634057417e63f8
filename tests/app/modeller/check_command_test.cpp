// Runs `stylet-model check PACKAGE` as a user does. Status 0: plausible, 1: refused, 2: cannot be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "patient/synth/labels.h"
#include "tests/app/modeller/reference_patient.h"
#include "tests/app/modeller/run_model.h"

namespace stylet::modeller {
namespace {

namespace fs = std::filesystem;
using patient::Package;
using patient::synth::Id;

// A package without a gas label. The thresholds decide where gas is.
Package makePatient() {
    Package p = test::referencePatient(1, 0.003);
    std::replace(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::gas), std::uint8_t(0));
    p.label_table.pop_back();
    return p;
}

test::ModelRun check(const fs::path& package) {
    return test::runModel("check '" + package.string() + "'");
}

TEST(CheckCommand, ReportsImplausiblePatients) {
    const test::TempFolder temp;
    Package p = makePatient();
    patient::savePackage(p, temp / "patient");
    const test::ModelRun plausible = check(temp / "patient");
    EXPECT_EQ(plausible.status, 0) << plausible.out;
    EXPECT_THAT(plausible.out, testing::HasSubstr("look     voxel size in x: 3 mm, expected 0.3 to 2.5 mm"));
    EXPECT_THAT(plausible.out, testing::Not(testing::HasSubstr("REFUSED")));

    std::replace(p.labels.voxels.begin(), p.labels.voxels.end(), std::uint8_t(Id::skin),
                 std::uint8_t(Id::fat));
    patient::savePackage(p, temp / "patient");
    const test::ModelRun refused = check(temp / "patient");
    EXPECT_EQ(refused.status, 1);
    EXPECT_EQ(refused.out.rfind("REFUSED  skin: 0 ml, expected at least", 0), 0u) << refused.out;

    fs::remove(temp / "patient" / "labels.nii.gz");
    const test::ModelRun damaged = check(temp / "patient");
    EXPECT_EQ(damaged.status, 2);
    EXPECT_THAT(damaged.err, testing::HasSubstr("labels.nii.gz"));
}

// A reference patient outside the ranges of its kind: each finding is printed and stored, and the exit status
// is the stored verdict.
// HZ-TEACH-22
TEST(CheckCommand, PrintsWhatItStores) {
    const test::TempFolder temp;
    Package p = test::referencePatient(1, 0.003);
    for (std::size_t i = 0; i < p.labels.voxels.size(); ++i)
        if (p.labels.voxels[i] == std::uint8_t(Id::ducts))
            p.ct.voxels[i] = std::int16_t(p.ct.voxels[i] + 100);
    patient::savePackage(p, temp / "patient");
    const test::ModelRun run = check(temp / "patient");
    const std::optional<patient::CheckVerdict> verdict = patient::loadVerdict(temp / "patient");
    ASSERT_TRUE(verdict) << run.err;
    EXPECT_EQ(run.status, verdict->refused ? 1 : 0) << run.out;
    EXPECT_THAT(run.out, testing::Not(testing::HasSubstr("FAIL")));
    for (const std::string& finding : verdict->findings)
        EXPECT_THAT(run.out, testing::HasSubstr(finding + "\n"));
    EXPECT_THAT(verdict->findings, testing::Contains(testing::StartsWith("look     mean of bile ducts: ")));
}

}  // namespace
}  // namespace stylet::modeller
