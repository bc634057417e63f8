// Motions that no hand makes but a broken device might report, and worst cases of geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/traversal.h"
#include "haptics/devices/profiles.h"
#include "tests/haptics/random_column.h"
#include "tests/haptics/scripted.h"
#include "tests/haptics/simulation_bench.h"
#include "tests/support/constants.h"
#include "tests/support/simulated_device.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::Hand;
using test::kFirmHand;
using test::kNaN;
using test::makeSimulatedBody;
using test::SimulatedBody;
using test::SimulatedDevice;

// Checks the invariants of the simulation in every tick.
struct CheckedBench : test::SimulationBench {
    using SimulationBench::SimulationBench;

    void tick() {
        SimulationBench::tick();
        const Vec3& f = out.sent_device_n;
        ASSERT_TRUE(isFinite(f));
        ASSERT_LE(glm::length(f), simulation.settings().profile.force_peak_n * (1.0 + 1e-12));
        ASSERT_TRUE(std::isfinite(out.tool_force.energy_j));
    }
    void to(const Vec3& tip_m) {
        input.device.device_from_stylus.position_m = tip_m;
        tick();
    }
    void rearm() {
        command(CommandKind::rearm);
        tick();
    }
    // Rests outside the patient until the start ramp is over.
    void settle() {
        for (int i = 0; i < 2000; ++i)
            to({-0.010, 0.0003, 0.0002});
    }
};

TEST(Adversarial, Leaps) {
    const patient::Package package = test::scriptedPackage();
    CheckedBench fed(package);
    fed.settle();
    test::Random random(5);
    for (int i = 0; i < 20000; ++i) {
        // Anywhere in reach, and sometimes at the far corners of the valid pose range.
        const double reach = i % 50 == 0 ? 9.9 : 0.08;
        const auto coordinate = [&] { return test::uniform(random, -reach, reach); };
        fed.to({coordinate(), coordinate(), coordinate()});
        if (i % 100 == 99) fed.rearm();
    }
    EXPECT_LE(fed.events.count, kMaxStepEvents);
    // Outside again, no effect of the earlier motion remains.
    fed.to({-0.010, 0.0003, 0.0002});
    fed.rearm();
    fed.settle();
    EXPECT_EQ(fed.out.phase, Phase::outside);
    EXPECT_EQ(glm::length(fed.out.sent_device_n), 0.0);
}

TEST(Adversarial, ImpossiblePosesAreRefused) {
    const patient::Package package = test::scriptedPackage();
    constexpr double kInf = HUGE_VAL;
    const Pose good{test::kAlongX, {0.020, 0.0003, 0.0002}};
    const Quat q = test::kAlongX;
    for (const Pose& bad :
         {Pose{q, {kNaN, 0.0, 0.0}}, Pose{q, {0.0, 0.0, -kInf}}, Pose{q, {0.0, 1e300, 0.0}},
          Pose{{kNaN, 0.0, 0.0, 0.0}, good.position_m}, Pose{{0.0, 0.0, 0.0, 0.0}, good.position_m},
          Pose{{2.0, 0.0, 0.0, 0.0}, good.position_m}, Pose{{kInf, 0.0, 0.0, 0.0}, good.position_m}}) {
        CheckedBench fed(package);
        fed.settle();
        for (int i = 0; i <= 300; ++i)
            fed.to({-0.010 + 0.0001 * i, 0.0003, 0.0002});
        ASSERT_GT(glm::length(fed.out.sent_device_n), 0.1);
        const Vec3 before = fed.out.patient_from_tool.position_m;
        fed.input.device.device_from_stylus = bad;
        fed.tick();
        EXPECT_NE(fed.out.faults, 0u);
        EXPECT_EQ(fed.out.patient_from_tool.position_m, before);  // the last valid pose stays
        for (int i = 0; i < 20; ++i)
            fed.tick();
        EXPECT_EQ(glm::length(fed.out.sent_device_n), 0.0);
        // A valid pose alone does not restore the force.
        fed.input.device.device_from_stylus = good;
        fed.tick();
        EXPECT_EQ(glm::length(fed.out.sent_device_n), 0.0);
        EXPECT_NE(fed.out.faults, 0u);
    }
}

// A firm hand hits bone at 50 mm/s, on each device. The needle must stop within the depth that the
// stiffness allows and come to rest.
TEST(Adversarial, FastOntoBone) {
    const patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.012}, {bone, 0.080}}, 0.0005);
    const patient::Patient patient(package);
    for (const DeviceProfile& profile : deviceProfiles()) {
        Trace wanted;
        const auto at = [&](double t_s, double x_m) {
            wanted.samples.push_back({std::int64_t(t_s * 1e9), {test::kAlongX, {x_m, 0.0003, 0.0002}}, 0});
        };
        at(0.0, -0.010), at(2.0, -0.010), at(2.6, 0.020), at(5.0, 0.020);
        SimulationSettings settings;
        settings.profile = profile;
        settings.profile.workspace_radius_m = kUnknown;
        Simulation simulation(patient, settings);
        SimulatedBody body = makeSimulatedBody(profile, kFirmHand);
        body.delay_s = 0.0005;
        SimulatedDevice device(wanted, settings.profile, body);
        TickInput input;
        TickOutput out;
        NeedleEvents events;
        double deepest_m = 0.0, moved_m = 0.0;
        bool on_bone = false;
        for (int i = 0; i < 5000; ++i) {
            input.device = device.read(std::int64_t(i) * 1000000);
            simulation.step(input, out, events);
            device.send(out.sent_device_n);
            deepest_m = std::max(deepest_m, device.body().position_m.x);
            on_bone = on_bone || (out.phase == Phase::tenting && out.depth_m > 0.0141);
            if (i == 4000) moved_m = device.body().position_m.x;
        }
        EXPECT_TRUE(on_bone) << profile.name;
        EXPECT_EQ(out.faults, 0u) << profile.name;
        // The hand spring, stretched by 6 mm, pushes against the bone's spring. The needle goes no deeper
        // than the hand's target, apart from oscillation.
        EXPECT_LT(deepest_m, 0.021) << profile.name;
        EXPECT_NEAR(device.body().position_m.x, moved_m, 1e-4) << profile.name;
        EXPECT_LT(glm::length(device.body().velocity_m_per_s), 2e-3) << profile.name;
    }
}

// Moves back and forth just before the puncture depth, a thousand times. The force must return to the same
// value without a puncture. Then the needle moves back and forth across that depth and must puncture exactly
// once.
TEST(Adversarial, ReversalJustBeforePunctureIsContinuous) {
    const patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.020}});
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.to(-0.001);
    hand.sweep(0.000875 - 1e-9);
    const double brink_n = hand.force();
    EXPECT_NEAR(brink_n, 0.7, 1e-5);
    for (int i = 0; i < 1000; ++i) {
        hand.to(0.000875 - 2e-9 - 1e-6 * (i % 7));
        hand.to(0.000875 - 1e-9);
        ASSERT_NEAR(hand.force(), brink_n, 1e-9);
    }
    EXPECT_TRUE(hand.eventsOf(NeedleEventKind::puncture).empty());
    hand.to(0.000875 + 1e-9);
    ASSERT_EQ(hand.eventsOf(NeedleEventKind::puncture).size(), 1u);
    for (int i = 0; i < 1000; ++i) {
        hand.to(0.000875 - 1e-9);
        ASSERT_NEAR(hand.force(), 0.7, 1e-5);
        hand.to(0.000875 + 1e-9);
    }
    EXPECT_EQ(hand.eventsOf(NeedleEventKind::puncture).size(), 1u);
    EXPECT_EQ(hand.state.phase, Phase::pass);
}

// Moves along a border: exactly on it, and beside it by a rounding error. The force must not chatter.
TEST(Adversarial, GrazingBorders) {
    const patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.010}, {liver, 0.030}}, 0.001);
    const patient::Patient patient(package);
    for (const double beside_m : {-1e-9, -1e-15, 0.0, 1e-15, 1e-9}) {
        Hand hand(patient);
        const double border_m = 0.012;
        hand.to(-0.001);
        hand.sweep(border_m + beside_m);
        // The shaft points along the border and moves 20 mm within it.
        hand.axis = {0.0, 0.0, 1.0};
        double before_n = hand.force();
        std::size_t steps = 0;
        for (int i = 1; i <= 400; ++i) {
            const std::size_t events = hand.events.size();
            hand.to(Vec3(border_m + beside_m, 0.0003, 0.0002 + 0.00005 * i));
            ASSERT_TRUE(std::isfinite(hand.force()));
            ASSERT_LE(std::fabs(hand.force()), 0.9 + 1e-9);
            // Slope of the springs: at most 1,200 N/m. Eq. 1 may be twice as steep.
            if (hand.events.size() == events)
                steps += std::fabs(hand.force() - before_n) > 2.0 * 1200.0 * 0.00005;
            before_n = hand.force();
        }
        EXPECT_EQ(steps, 0u) << beside_m;
        EXPECT_LT(hand.events.size(), 12u) << beside_m;
    }
}

TEST(Adversarial, ZeroLengthPathsGiveFiniteForces) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    const Vec3 inside{0.0145, 0.0, 0.0}, border{0.014, 0.0, 0.0};
    for (const Vec3& p : {inside, border}) {
        VoxelPath path;
        std::vector<Segment> segments;
        segmentsAlong(patient::TissueMap(patient), p, p, path, segments);
        const ExactForce exact = solveExact(patient.package().tissues, segments, 0.0, {});
        EXPECT_TRUE(std::isfinite(exact.at(0.0)));
        EXPECT_TRUE(std::isfinite(exact.at(1.0)));
    }
    // A hand that never moves, at several positions. The needle has no direction of travel.
    for (const double x : {-0.01, 0.0, 0.001, 0.014, 0.0145, 0.1}) {
        Hand hand(patient);
        for (int i = 0; i < 100; ++i)
            hand.to(x);
        EXPECT_EQ(hand.force(), 0.0) << x;
    }
}

// There are more borders than any list can store. The overflow is counted, without memory errors, and the
// needle can be withdrawn again.
TEST(Adversarial, ThousandThinLayersOverflowInACountedWay) {
    test::Layers layers{{skin, 0.0002}};
    for (int i = 0; i < 1000; ++i)
        layers.push_back({i % 2 == 0 ? fascia : liver, 0.0001});
    layers.push_back({soft, 0.005});
    const patient::Package package = test::makeColumn(layers);
    const patient::Patient patient(package);
    for (const double step_m : {0.00002, 0.0005, 0.02, 0.1}) {
        Hand hand(patient);
        hand.to(-0.001);
        double most_n = 0.0;
        while (hand.state.tip_deformed_m.x < 0.104) {
            const double x = std::min(0.104, hand.state.tip_deformed_m.x + step_m);
            haptics::NeedleEvents events;
            stepNeedle(hand.state, hand.settings, {patient, {}}, {{x, 0.0003, 0.0002}, hand.axis}, events);
            ASSERT_LE(hand.state.queued_count, kMaxQueuedBorders);
            ASSERT_LE(hand.state.cut_count, kMaxCutBorders);
            ASSERT_TRUE(std::isfinite(hand.force()));
            most_n = std::max(most_n, std::fabs(hand.force()));
        }
        EXPECT_LE(most_n, 2.5 + 1e-9) << step_m;
        EXPECT_EQ(hand.state.tissue, soft) << step_m;
        EXPECT_NEAR(hand.force(), 0.7, 1e-9) << step_m;
        hand.to(-0.010);
        EXPECT_EQ(hand.state.phase, Phase::outside) << step_m;
        EXPECT_EQ(hand.force(), 0.0) << step_m;
    }
}

// One tick through all layers. Events that do not fit into the event list are counted.
TEST(Adversarial, JumpThroughAThousandLayersTakesOneTick) {
    test::Layers layers{{skin, 0.0002}};
    for (int i = 0; i < 1000; ++i)
        layers.push_back({i % 3 == 0 ? liver : i % 3 == 1 ? duct : vessel, 0.0001});
    const patient::Package package = test::makeColumn(layers);
    const patient::Patient patient(package);
    Hand hand(patient);
    hand.to(-0.01);
    for (int i = 0; i < 100; ++i) {
        NeedleEvents events;
        stepNeedle(hand.state, hand.settings, {patient, {}}, {{0.09, 0.0003, 0.0002}, hand.axis}, events);
        EXPECT_EQ(events.count, kMaxStepEvents);
        EXPECT_GT(events.dropped, 0);
        hand.to(-0.01);
        EXPECT_EQ(hand.state.phase, Phase::outside);
    }
}

}  // namespace
}  // namespace stylet::haptics
