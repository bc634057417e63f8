// What the room and the device are arranged around. In an exam none of it may tell where the planned path
// runs.
#include "app/trainer/attempt/staging.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/attempt.h"
#include "haptics/devices/clutch.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"

namespace stylet::trainer {
namespace {

using training::Difficulty;

class Staging : public testing::Test {
  protected:
    Staging() {
        there_.entry_m.z += 0.010, there_.entry_reference_m.z += 0.010;
        there_.target_m.y += 0.008, there_.target_reference_m.y += 0.008;
    }
    OperativeField field(const patient::PlannedPath& path, Difficulty difficulty) const {
        return operativeField(patient_, path, test::difficulties()[difficulty]);
    }
    Pose devicePlace(const patient::PlannedPath& path, Difficulty difficulty, std::uint64_t seed,
                     bool senses_rotation, double workspace_radius_m) const {
        AttemptConfig config;
        config.difficulties = test::difficulties(), config.difficulty = difficulty, config.seed = seed;
        haptics::DeviceProfile profile;
        profile.senses_rotation = senses_rotation, profile.workspace_radius_m = workspace_radius_m;
        return makeLiveAttempt(patient_, test::shortScenario(), path, config, touch_, {.profile = profile})
            .simulation.patient_from_device;
    }

    const patient::Package package_ = test::ductPhantom();
    const patient::Patient patient_{package_};
    const haptics::TouchMap touch_ = haptics::makeTouchMap(patient_);
    const patient::PlannedPath here_ = test::ductPath();
    patient::PlannedPath there_ = here_;
};

// HZ-TEACH-24
TEST_F(Staging, FieldFollowsThePathExceptInAnExam) {
    for (const Difficulty difficulty : {Difficulty::guided, Difficulty::practice})
        for (const patient::PlannedPath& path : {here_, there_}) {
            const OperativeField shown = field(path, difficulty);
            EXPECT_EQ(shown.entry_m, path.entry_m);
            EXPECT_EQ(shown.inside_m, path.target_m);
            EXPECT_EQ(shown.entry_reference_m, path.entry_reference_m);
            EXPECT_NEAR(glm::distance(shown.isocentre_m, path.target_reference_m), 0.035, 1e-12);
        }
    const OperativeField one = field(here_, Difficulty::exam), other = field(there_, Difficulty::exam);
    EXPECT_EQ(one.entry_m, other.entry_m);
    EXPECT_EQ(one.inside_m, other.inside_m);
    EXPECT_EQ(one.entry_reference_m, other.entry_reference_m);
    EXPECT_EQ(one.isocentre_m, other.isocentre_m);
}

TEST_F(Staging, FlankIsOnTheRightSkinBesideTheLiver) {
    const OperativeField flank = flankField(patient_);
    const double voxel_m = patient_.grid().spacing_m.x;
    const auto tissueAt = [&](const Vec3& at_m) { return patient_.at(at_m, {true, true}).tissue; };
    EXPECT_NE(tissueAt(flank.entry_m), patient::Tissue::air);
    EXPECT_EQ(tissueAt(flank.entry_m + Vec3(2.0 * voxel_m, 0.0, 0.0)), patient::Tissue::air);
    EXPECT_GT(flank.entry_m.x, flank.inside_m.x);
    EXPECT_NEAR(flank.entry_m.z, flank.inside_m.z, voxel_m);
}

// A hand that only pushes the device along its axis must stay far from the target. HZ-TEACH-24
TEST_F(Staging, DeviceIsPlacedBesideThePathInAnExam) {
    const Vec3 along = glm::normalize(here_.target_m - here_.entry_m);
    for (const double radius_m : {0.045, 0.075, 0.1})
        for (std::uint64_t seed = 1; seed <= 30; ++seed) {
            const Pose placed = devicePlace(here_, Difficulty::exam, seed, true, radius_m);
            const Vec3 pushed = placed.direction({0.0, 0.0, -1.0}),
                       to_target_m = here_.target_m - placed.position_m;
            const double miss_m = glm::length(to_target_m - glm::dot(to_target_m, pushed) * pushed);
            const double off_rad = std::acos(std::clamp(glm::dot(pushed, along), -1.0, 1.0));
            EXPECT_GT(miss_m, radius_m > 0.09 ? 0.015 : 0.004) << radius_m << " " << seed;
            EXPECT_GT(off_rad, radius_m > 0.09 ? 0.1 : 0.02) << radius_m << " " << seed;
            // The whole path is within reach, in front of the soft wall.
            for (const Vec3& at_m : {here_.target_m, here_.entry_m})
                EXPECT_LT(glm::length(at_m - placed.position_m), 0.9 * radius_m + 1e-9)
                    << radius_m << " " << seed;
        }
    EXPECT_NE(devicePlace(here_, Difficulty::exam, 1, true, 0.1).position_m,
              devicePlace(here_, Difficulty::exam, 2, true, 0.1).position_m);
}

TEST_F(Staging, DeviceIsPlacedAlongThePathOtherwise) {
    constexpr double kReach_m = 0.1;
    const Vec3 along = glm::normalize(here_.target_m - here_.entry_m);
    for (const bool senses_rotation : {true, false}) {
        const Pose placed = devicePlace(here_, Difficulty::practice, 1, senses_rotation, kReach_m);
        EXPECT_NEAR(glm::dot(placed.direction({0.0, 0.0, -1.0}), along), 1.0, 1e-12);
    }
}

}  // namespace
}  // namespace stylet::trainer
