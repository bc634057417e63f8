#include "app/trainer/attempt/hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "patient/patient.h"
#include "tests/app/trainer/assets.h"

namespace stylet::trainer {
namespace {

struct Walk {
    patient::PlannedPath path;
    double breath_s = 4.0;
    Pose patient_from_device = placeDeviceBeside({{100, 80, 60}, Vec3(0.004), Vec3(-0.2, -0.1, 1.0)});

    Walk() {
        path.entry_m = {0.15, 0.05, 1.10};
        path.target_m = {0.08, 0.02, 1.13};
    }
    double length_m() const { return glm::length(path.target_m - path.entry_m); }
    Vec3 axis() const { return (path.target_m - path.entry_m) / length_m(); }
    haptics::Trace hand(const Scenario& s, std::uint64_t seed = 1, double capsule_m = 0.0) const {
        haptics::SimulationSettings settings;
        settings.patient_from_device = patient_from_device;
        return makeScriptedTrace(s, path, breath_s, settings, seed, capsule_m);
    }
    double depthAt(const haptics::TraceSample& sample) const {
        return glm::dot((patient_from_device * sample.device_from_stylus).position_m - path.entry_m, axis());
    }
};

Scenario demo() {
    return loadScenario(test::assets() / "scenarios" / "demo.toml");
}

Scenario straightIn() {
    Scenario s;
    s.start.deeper_m = -0.020;
    s.tremor_m = 0.0;
    Stage in;
    in.kind = StageKind::move;
    in.to = {1.0, 0.001};
    in.speed_m_s = 0.013;
    s.stages = {in};
    return s;
}

TEST(Hand, APlaceMayBeRelativeToTheCapsule) {
    const Walk walk;
    Scenario s = straightIn();
    s.stages[0].to = {.share = 0.5, .deeper_m = -0.003, .to_capsule = true};
    EXPECT_NEAR(walk.depthAt(walk.hand(s, 1, 0.030).samples.back()), 0.012, 1e-12);
}

TEST(Hand, EndsWhereTheScenarioSaysOnThePlannedPath) {
    const Walk walk;
    const haptics::Trace trace = walk.hand(straightIn());
    EXPECT_NEAR(walk.depthAt(trace.samples.front()), -0.020, 1e-4);
    EXPECT_NEAR(walk.depthAt(trace.samples.back()), walk.length_m() + 0.001, 1e-12);
    for (const haptics::TraceSample& s : trace.samples) {
        const Pose needle = walk.patient_from_device * s.device_from_stylus;
        EXPECT_LT(glm::length(glm::cross(needle.position_m - walk.path.entry_m, walk.axis())), 1e-12);
        EXPECT_LT(glm::length(needle.direction({0, 0, 1}) + walk.axis()), 1e-12);  // +z points to the hub
    }
}

TEST(Hand, StartsAndStopsSmoothly) {
    const Walk walk;
    const haptics::Trace trace = walk.hand(straightIn());
    double last_speed = 0.0, top = 0.0, largest_change = 0.0;
    for (std::size_t i = 1; i < trace.samples.size(); ++i) {
        const double speed = (walk.depthAt(trace.samples[i]) - walk.depthAt(trace.samples[i - 1])) / 0.001;
        EXPECT_GE(speed, -1e-9);
        largest_change = std::max(largest_change, std::abs(speed - last_speed) / 0.001);
        top = std::max(top, speed);
        last_speed = speed;
    }
    EXPECT_NEAR(top, 0.013, 1e-6);
    // The steepest slope of the minimum-jerk step is 15/8: acceleration 15/8 * 0.013 / 0.4 s.
    EXPECT_NEAR(largest_change, 1.875 * 0.013 / 0.4, 0.002);
}

TEST(Hand, ShortMovesAreSlowerAndStillArrive) {
    const Walk walk;
    Scenario s = straightIn();
    s.stages[0].to = {0.0, -0.019};
    EXPECT_NEAR(walk.depthAt(walk.hand(s).samples.back()), -0.019, 1e-12);
}

TEST(Hand, TheDemoNeverExceedsTwentyMillimetresASecondInsideTheBody) {
    const Walk walk;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const haptics::Trace trace = walk.hand(demo(), seed);
        for (std::size_t i = 1; i < trace.samples.size(); ++i) {
            if (walk.depthAt(trace.samples[i]) < 0.0) continue;
            const double speed =
                (walk.depthAt(trace.samples[i]) - walk.depthAt(trace.samples[i - 1])) / 0.001;
            ASSERT_LE(std::abs(speed), 0.020) << "sample " << i;
        }
    }
}

TEST(Hand, TheDemoStaysOffTheSkinUntilTheHoldHasSurelyBegun) {
    const Walk walk;
    const haptics::Trace trace = walk.hand(demo());
    ASSERT_EQ(trace.commands.size(), 2u);
    EXPECT_EQ(trace.commands[0].command.kind, haptics::CommandKind::holdBreath);
    EXPECT_EQ(trace.commands[1].command.kind, haptics::CommandKind::breathe);
    const std::int64_t certain_ns = trace.commands[0].t_ns + std::int64_t(walk.breath_s * 1e9);
    const std::int64_t breathe_ns = trace.commands[1].t_ns;
    for (const haptics::TraceSample& s : trace.samples) {
        if (s.t_ns < certain_ns || s.t_ns > breathe_ns) {
            EXPECT_LT(walk.depthAt(s), -0.005);
        }
    }
    EXPECT_GT(trace.samples.back().t_ns, std::int64_t(25e9));
    EXPECT_LT(trace.samples.back().t_ns, std::int64_t(40e9));
}

TEST(Hand, OffsetsPointTowardHeadAndFront) {
    const Walk walk;
    Scenario s = straightIn();
    s.stages[0].to = {0.0, -0.020, 0.006, 0.002};
    const haptics::Trace trace = walk.hand(s);
    const Vec3 moved = (walk.patient_from_device * trace.samples.back().device_from_stylus).position_m -
                       (walk.patient_from_device * trace.samples.front().device_from_stylus).position_m;
    EXPECT_NEAR(glm::dot(moved, walk.axis()), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(moved), std::sqrt(0.006 * 0.006 + 0.002 * 0.002), 1e-9);
    EXPECT_GT(moved.z, 0.005);
    EXPECT_GT(moved.y, 0.0);
}

// During the move, the tool smoothly leans about its tip and rolls about its shaft. This does not change the
// motion of the tip.
TEST(Hand, LeansAndRollsTheToolAsItMoves) {
    const Walk walk;
    Scenario s = straightIn(), straight = straightIn();
    s.stages[0].to = {0.5, 0.0, 0.0, 0.0, 0.2, -0.1, 0.5};
    straight.stages[0].to = {0.5, 0.0};
    const haptics::Trace trace = walk.hand(s), plain = walk.hand(straight);
    ASSERT_EQ(trace.samples.size(), plain.samples.size());
    const auto needle = [&](const haptics::TraceSample& sample) {
        return walk.patient_from_device * sample.device_from_stylus;
    };
    double most_rad = 0.0;
    for (std::size_t i = 1; i < trace.samples.size(); ++i) {
        EXPECT_LT(glm::length(needle(trace.samples[i]).position_m - needle(plain.samples[i]).position_m),
                  1e-12);
        const double turned =
            std::fabs(glm::dot(needle(trace.samples[i - 1]).rotation, needle(trace.samples[i]).rotation));
        most_rad = std::max(most_rad, 2.0 * std::acos(std::min(1.0, turned)));
    }
    EXPECT_LT(most_rad, 0.001) << "in a millisecond";
    const Vec3 into = -needle(trace.samples.back()).direction({0, 0, 1});
    const double along = glm::dot(into, walk.axis());
    const Vec3 headward = glm::normalize(Vec3(0, 0, 1) - walk.axis() * walk.axis().z);
    EXPECT_NEAR(glm::dot(into, headward) / along, std::tan(0.2), 1e-9);
    EXPECT_NEAR(std::sqrt(1.0 / (along * along) - 1.0), std::hypot(std::tan(0.2), std::tan(0.1)), 1e-9);
    // Compare the roll with that of a needle that only leans.
    s.stages[0].to.roll_rad = 0.0;
    const Pose leant = needle(walk.hand(s).samples.back()), rolled = needle(trace.samples.back());
    EXPECT_NEAR(glm::dot(leant.direction({1, 0, 0}), rolled.direction({1, 0, 0})), std::cos(0.5), 1e-9);
    EXPECT_NEAR(glm::dot(leant.direction({0, 0, 1}), rolled.direction({0, 0, 1})), 1.0, 1e-12);
}

// With the guide: the probe is parked with its rail on the path, and the needle then follows the rail.
TEST(Hand, HoldsTheProbeSoThatItsGuideIsOnThePath) {
    const Walk walk;
    Scenario s = straightIn();
    s.tool = haptics::Tool::probe;
    Stage wait, park, take;
    wait.seconds = 0.01;
    park.kind = StageKind::park;
    take.kind = StageKind::changeTool;
    take.tool = haptics::Tool::guide;
    take.seconds = 0.5;
    s.stages = {wait, park, take};
    const haptics::Trace trace = walk.hand(s);
    ASSERT_EQ(trace.commands.size(), 2u);
    EXPECT_EQ(trace.commands[0].command.kind, haptics::CommandKind::park);
    EXPECT_EQ(trace.commands[1].command.value, std::uint32_t(haptics::Tool::guide));

    const Pose patient_from_probe =
        walk.patient_from_device * trace.samples.front().device_from_stylus * haptics::kStylusFromProbe;
    EXPECT_GT(glm::dot(patient_from_probe.direction({0, 0, 1}), walk.axis()), 0.9);  // tilted by 25 degrees
    const Pose rail = patient_from_probe * haptics::GuideSettings{}.probe_from_guide;
    EXPECT_LT(glm::length(glm::cross(rail.position_m - walk.path.entry_m, walk.axis())), 1e-12);
    EXPECT_LT(glm::length(rail.direction({0, 0, 1}) + walk.axis()), 1e-12);
    // The plane of the probe's face meets the path at the scripted tip position.
    const Vec3 tip = walk.path.entry_m - 0.020 * walk.axis();
    EXPECT_NEAR((patient_from_probe.inverse() * tip).z, 0.0, 1e-12);
    EXPECT_NEAR(walk.depthAt(trace.samples.back()), -0.020, 1e-12);  // the needle's tip

    double fastest_m = 0.0;
    for (std::size_t i = 1; i < trace.samples.size(); ++i)
        fastest_m = std::max(fastest_m, glm::length(trace.samples[i].device_from_stylus.position_m -
                                                    trace.samples[i - 1].device_from_stylus.position_m));
    EXPECT_LT(fastest_m, 0.0002);  // no jump when the grip changes from tool to tool
}

TEST(Hand, RefusesAScenarioOfMoreThanAnHour) {
    Scenario s = straightIn();
    Stage wait;
    wait.seconds = 600.0;
    s.stages.assign(7, wait);
    EXPECT_THROW((void)Walk().hand(s), DataError);
}

TEST(Hand, TremorComesFromTheSeedAndStaysSmall) {
    const Walk walk;
    Scenario still = straightIn();
    still.tremor_m = 0.0001;
    const haptics::Trace a = walk.hand(still, 1), b = walk.hand(still, 1), c = walk.hand(still, 2);
    Scenario steady = still;
    steady.tremor_m = 0.0;
    const haptics::Trace calm = walk.hand(steady, 1);
    double difference = 0.0, excursion = 0.0;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
        const Vec3 p = a.samples[i].device_from_stylus.position_m;
        EXPECT_EQ(p, b.samples[i].device_from_stylus.position_m);
        difference = std::max(difference, glm::length(p - c.samples[i].device_from_stylus.position_m));
        excursion = std::max(excursion, glm::length(p - calm.samples[i].device_from_stylus.position_m));
    }
    EXPECT_GT(difference, 0.00003);
    EXPECT_GT(excursion, 0.00003);
    EXPECT_LT(excursion, 0.0001);
}

TEST(Hand, TheDeviceStandsOutsideTheGridWithItsYUp) {
    const Grid grid{{100, 80, 60}, Vec3(0.004), Vec3(-0.2, -0.1, 1.0)};
    const Pose patient_from_device = placeDeviceBeside(grid);
    EXPECT_FALSE(grid.contains(grid.nearest(patient_from_device.position_m)));
    EXPECT_LT(glm::length(patient_from_device.direction({0, 1, 0}) - Vec3(0, 1, 0)), 1e-12);
    EXPECT_LT(glm::length(patient_from_device.direction({0, 0, 1}) - Vec3(1, 0, 0)), 1e-12);
}

}  // namespace
}  // namespace stylet::trainer
