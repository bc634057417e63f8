// Runs the program on a coarse reference patient.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "patient/patient.h"
#include "tests/app/modeller/run_model.h"

namespace stylet::modeller {
namespace {

int runModel(const std::string& arguments) {
    return test::runModel(arguments).status;
}

TEST(MotionCommand, TemplateUsesGivenAmplitudesAndReferencePhase) {
    const test::TempFolder folder;
    const std::string made = (folder / "made").string(), moved = (folder / "moved").string();
    ASSERT_EQ(runModel("synth --seed 2 --spacing-mm 4 --out " + made), 0);
    ASSERT_EQ(runModel("motion --template --package " + made +
                       " --dome-mm 20 --reference-phase inhale --out " + moved),
              0);
    const patient::Package before = patient::loadPackage(made), after = patient::loadPackage(moved);
    EXPECT_EQ(before.reference_phase, "exhale");
    EXPECT_EQ(after.reference_phase, "inhale");
    EXPECT_EQ(after.motion.reference.v, 1.0);
    EXPECT_DOUBLE_EQ(after.motion.dome_travel_m, 0.020);
    EXPECT_EQ(after.labels.voxels, before.labels.voxels);
    // The centre of the liver does not move at the breathing state of the CT. It rises by the travel toward
    // end-exhale.
    Vec3 middle(0.0);
    std::size_t count = 0;
    forEachVoxel(after.labels.grid, [&](const Index3& i) {
        for (const patient::Label& label : after.label_table)
            if (label.id == after.labels[i] && label.tissue == patient::Tissue::liver)
                middle += after.labels.grid.centre(i), ++count;
    });
    ASSERT_GT(count, 1000u);
    middle /= double(count);
    EXPECT_NEAR(deformedFromReference(after.motion, {1.0, 0.0}, middle).z, middle.z, 1e-12);
    EXPECT_NEAR(deformedFromReference(after.motion, {0.0, 0.0}, middle).z - middle.z, 0.020, 0.004);
}

// The package is written for inspection; the exit status is the stored verdict, as for the other commands.
// HZ-TEACH-22
TEST(MotionCommand, RefusedPatientEndsWithStatusOne) {
    const test::TempFolder folder;
    const std::string made = (folder / "made").string(), moved = (folder / "moved").string();
    ASSERT_EQ(runModel("synth --seed 2 --spacing-mm 4 --out " + made), 0);
    patient::Package naked = patient::loadPackage(made);
    for (const patient::Label& label : naked.label_table)
        if (label.tissue == patient::Tissue::skin)
            std::replace(naked.labels.voxels.begin(), naked.labels.voxels.end(), label.id, std::uint8_t(0));
    patient::savePackage(naked, made);
    const test::ModelRun run = test::runModel("motion --template --package " + made + " --out " + moved);
    EXPECT_EQ(run.status, 1) << run.out;
    EXPECT_NE(run.out.find("REFUSED  skin: 0 ml"), std::string::npos) << run.out;
    const std::optional<patient::CheckVerdict> verdict = patient::loadVerdict(moved);
    ASSERT_TRUE(verdict);
    EXPECT_TRUE(verdict->refused);
}

TEST(MotionCommand, InvalidArgumentsAreRefused) {
    const test::TempFolder folder;
    const std::string out = (folder / "out").string();
    EXPECT_NE(runModel("motion --out " + out), 0);
    EXPECT_NE(runModel("motion --template --out " + out), 0);
    EXPECT_NE(runModel("motion --template --package /no/such --out " + out), 0);
    EXPECT_NE(runModel("motion --template --phases /tmp --package /no/such --out " + out), 0);
    EXPECT_NE(runModel("motion --template --package /no/such --dome-mm 400 --out " + out), 0);
    EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace stylet::modeller
