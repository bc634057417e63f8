// What the room and the device are arranged around. In an exam none of it may tell where the planned path
// runs.
#include "app/trainer/attempt/staging.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/random.h"
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
        return makeLiveAttempt(patient_, test::shortScenario(), path, field(path, difficulty), config, touch_,
                               {.profile = profile})
            .simulation.patient_from_device;
    }

    // Paths into the liver from the right and the front.
    std::vector<patient::PlannedPath> drawnPaths(int count) const {
        const OperativeField flank = flankField(patient_);
        Random random{7};
        std::vector<patient::PlannedPath> paths;
        for (int i = 0; i < count; ++i) {
            const auto drawn = [&](double most) { return random.between(-most, most); };
            patient::PlannedPath path;
            path.target_m = flank.inside_m;
            for (int axis = 0; axis < 3; ++axis)
                path.target_m[axis] += drawn(0.025);
            path.length_m = random.between(0.04, 0.07);
            const double front = random.between(-0.3, 1.5), head = drawn(0.5);
            path.entry_m = path.target_m + path.length_m * glm::normalize(Vec3(1.0, front, head));
            paths.push_back(path);
        }
        return paths;
    }
    static bool reaches(const Pose& placed, double radius_m, const patient::PlannedPath& path) {
        return std::max(glm::distance(path.entry_m, placed.position_m),
                        glm::distance(path.target_m, placed.position_m)) <= 0.9 * radius_m;
    }
    static constexpr std::array kRadii_m{0.045, 0.06, 0.075, 0.1, 0.25};

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

// HZ-TEACH-24
TEST_F(Staging, AnExamsDeviceIsTurnedAsTheRoomIsAndReachesThePath) {
    const std::vector<patient::PlannedPath> paths = drawnPaths(30);
    const Quat room = stageFromPatient(patient_, flankField(patient_)).inverse().rotation;
    for (const double radius_m : kRadii_m)
        for (std::size_t i = 0; i < paths.size(); ++i) {
            const Pose placed = devicePlace(paths[i], Difficulty::exam, i + 1, true, radius_m);
            EXPECT_NEAR(std::fabs(glm::dot(placed.rotation, room)), 1.0, 1e-12);
            for (const Vec3& at_m : {paths[i].target_m, paths[i].entry_m})
                EXPECT_LT(glm::distance(at_m, placed.position_m), 0.9 * radius_m + 1e-9)
                    << radius_m << " " << i;
        }
    EXPECT_EQ(devicePlace(paths[0], Difficulty::exam, 1, true, 0.25).position_m,
              devicePlace(paths[1], Difficulty::exam, 2, true, 0.25).position_m)
        << "a large workspace always has the same place";
}

// A place on the path would reveal it.
TEST_F(Staging, AnExamOnAPathLongerThanTheWorkspaceIsRefused) {
    patient::PlannedPath path = drawnPaths(1).front();
    path.target_m = path.entry_m + 0.09 / path.length_m * (path.target_m - path.entry_m);
    path.length_m = 0.09;
    EXPECT_THROW(devicePlace(path, Difficulty::exam, 1, true, 0.035), UsageError);
    EXPECT_NO_THROW(devicePlace(path, Difficulty::practice, 1, true, 0.035));
}

// A cheat who pushes the device's tool along an axis through the middle of the workspace, or straight to that
// middle, comes no nearer to the target than to other targets that the device reaches as well. HZ-TEACH-24
TEST_F(Staging, AnExamsDeviceTellsNothingButThatThePathIsWithinReach) {
    const std::vector<patient::PlannedPath> paths = drawnPaths(100);
    for (const double radius_m : kRadii_m) {
        std::vector<Pose> placed;
        for (const patient::PlannedPath& path : paths)
            placed.push_back(devicePlace(path, Difficulty::exam, placed.size() + 1, true, radius_m));
        for (const bool along_axis : {true, false}) {
            const auto miss_m = [&](const Pose& device, const patient::PlannedPath& path) {
                const Vec3 to_target_m = path.target_m - device.position_m,
                           pushed = device.direction({0.0, 0.0, -1.0});
                return glm::length(along_axis ? to_target_m - glm::dot(to_target_m, pushed) * pushed
                                              : to_target_m);
            };
            double gain_m = 0.0, spread_m2 = 0.0;  // of the own target over the mean of the others
            for (std::size_t i = 0; i < paths.size(); ++i) {
                double sum_m = 0.0, count = 0.0;
                for (const patient::PlannedPath& other : paths)
                    if (reaches(placed[i], radius_m, other)) sum_m += miss_m(placed[i], other), count += 1.0;
                ASSERT_GT(count, 0.0);
                const double one_m = sum_m / count - miss_m(placed[i], paths[i]);
                gain_m += one_m, spread_m2 += one_m * one_m;
            }
            EXPECT_LT(gain_m, 3.0 * std::sqrt(spread_m2)) << radius_m << " " << along_axis;
        }
    }
}

TEST_F(Staging, DeviceIsPlacedAlongThePathOtherwise) {
    constexpr double kReach_m = 0.1;
    const Vec3 along = glm::normalize(here_.target_m - here_.entry_m);
    for (const bool senses_rotation : {true, false}) {
        const Pose placed = devicePlace(here_, Difficulty::practice, 1, senses_rotation, kReach_m);
        EXPECT_NEAR(glm::dot(placed.direction({0.0, 0.0, -1.0}), along), 1.0, 1e-12);
    }
}

TEST_F(Staging, PathRunsThroughTheGripWhenTheWorkspaceIsUnknown) {
    const Pose grip{{1.0, 0.0, 0.0, 0.0}, {0.5, -0.4, 0.6}};
    const Attempt attempt = makeLiveAttempt(
        patient_, test::shortScenario(), here_, field(here_, Difficulty::practice),
        {.difficulties = test::difficulties()}, touch_, {.profile = {}, .device_from_grip = grip});
    const Vec3 grip_m = attempt.simulation.patient_from_device * grip.position_m,
               along = glm::normalize(here_.target_m - here_.entry_m), from_entry_m = grip_m - here_.entry_m;
    const double deep_m = glm::dot(from_entry_m, along);
    EXPECT_LT(glm::length(from_entry_m - deep_m * along), 1e-12);
    EXPECT_NEAR(deep_m, 0.5 * (here_.length_m - 0.02), 1e-12);  // the middle, from 20 mm outside the body
}

}  // namespace
}  // namespace stylet::trainer
