// Tests the selection of the reference path, against which an attempt is scored.
#include "app/trainer/attempt/reference_path.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "app/records/record.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

class ReferencePath : public testing::Test {
  protected:
    // An attempt whose needle runs `aside_m` beside the phantom's path.
    std::string attempt(const patient::Patient& on, const char* scenario, double aside_m) {
        patient::PlannedPath path = test::ductPath();
        for (Vec3* end : {&path.entry_m, &path.entry_reference_m, &path.target_m, &path.target_reference_m})
            end->y += aside_m;
        const Scenario script =
            loadScenario(test::assets() / "scenarios" / (std::string(scenario) + ".toml"));
        const Attempt made = makeAttempt(on, script, path, 1);
        records::RecordInfo info;
        info.path = path;
        const std::filesystem::path folder = folder_ / scenario;
        records::RecordWriter writer(folder / "record", {patient::digest(on.package()), made.simulation},
                                     info);
        Session session(on, path, {}, 0.0, &writer);
        runFast(made, session, nullptr, 0.0, {});
        writer.finish();
        return folder;
    }
    // Returns the error message of referencePath(), or an empty string if it accepts the path.
    std::string refusal(const patient::Patient& patient, const std::string& asked) {
        try {
            referencePath(patient, folder_.path(), asked, training::Course::puncture);
            return "";
        } catch (const DataError& e) {
            return e.what();
        }
    }
    test::TempFolder folder_;
    const patient::Package package_ = test::ductPhantom();
    const patient::Patient patient_{package_};
};

TEST_F(ReferencePath, CanBeAnExpertsNeedleTrack) {
    const patient::PlannedPath path =
        referencePath(patient_, folder_.path(), attempt(patient_, "demo", 0.006), training::Course::puncture);
    EXPECT_NEAR(path.entry_m.x, 0.0, 0.001);
    EXPECT_NEAR(path.entry_m.y, 0.006, 0.001);
    EXPECT_NEAR(path.target_m.x, 0.050, 0.002) << "the duct's near wall";
    EXPECT_NEAR(path.target_m.y, 0.006, 0.001);
    EXPECT_NEAR(path.length_m, glm::length(path.target_m - path.entry_m), 1e-12);
    EXPECT_EQ(path.breath, patient::Surrogate{});
}

TEST_F(ReferencePath, RefusesAnAttemptThatMissedTheTarget) {
    const std::string missed = attempt(patient_, "wrong-tip", 0.0);
    EXPECT_NE(refusal(patient_, missed).find("did not reach"), std::string::npos);
}

// HZ-TEACH-07
TEST_F(ReferencePath, RefusesAnAttemptOnAnotherPatient) {
    const std::string his = attempt(patient_, "demo", 0.0);
    patient::Package other = package_;
    other.signal.period_s = 4.0;
    EXPECT_NE(refusal(patient::Patient(other), his).find("patient"), std::string::npos);
    EXPECT_NE(refusal(patient_, folder_ / "nowhere").find("nowhere"), std::string::npos);
}

TEST_F(ReferencePath, SelectsAPlannedPathByNumber) {
    patient::StoredPaths stored{
        patient::digest(package_), patient::kPlannerVersion, {test::ductPath(), test::ductPath()}};
    stored.paths[1].entry_m.y = stored.paths[1].entry_reference_m.y = 0.004;
    patient::savePaths(stored, folder_ / "paths.json");
    EXPECT_EQ(referencePath(patient_, folder_.path(), "", training::Course::puncture).entry_m,
              stored.paths[0].entry_m);
    EXPECT_EQ(referencePath(patient_, folder_.path(), "2", training::Course::puncture).entry_m,
              stored.paths[1].entry_m);
    for (const char* none : {"0", "3"})
        EXPECT_NE(refusal(patient_, none).find("1 to 2"), std::string::npos);
}

}  // namespace
}  // namespace stylet::trainer
