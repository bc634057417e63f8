#include "haptics/loop/toolbox.h"

#include <gtest/gtest.h>

#include <set>

#include "base/hash.h"
#include "haptics/loop/simulation.h"
#include "tests/haptics/scripted.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum Tissue;

// A hand at the device of a patient at rest. The needle points along +x.
struct ToolBench {
    explicit ToolBench(double travel_m = 0.0, Tool first = Tool::needle)
        : package(test::makeColumn({{skin, 0.002}, {soft, 0.012}, {liver, 0.04}})), patient(package) {
        if (travel_m != 0.0) test::letBreathe(package, travel_m);
        settings.tools.first = first;
        simulation.emplace(patient, settings);
    }
    ToolBench(const patient::Package& of, Tool first) : package(of), patient(package) {
        settings.tools.first = first;
        simulation.emplace(patient, settings);
    }
    void command(CommandKind kind, std::uint32_t value) {
        input.commands[input.command_count++] = {kind, value};
    }
    void take(Tool tool) { command(CommandKind::tool, std::uint32_t(tool)); }
    void to(const Vec3& tip_m) {
        input.device.device_from_stylus = {test::kAlongX, tip_m};
        simulation->step(input, out, events);
        input.command_count = 0;
    }
    void to(double x_m) { to({x_m, 0.0003, 0.0002}); }
    void sweep(double x_m) {
        Vec3 tip = input.device.device_from_stylus.position_m;
        while (std::fabs(x_m - tip.x) > 1e-9) {
            tip.x += std::clamp(x_m - tip.x, -0.00009, 0.00009);
            to(tip);
        }
    }
    patient::Package package;
    patient::Patient patient;
    SimulationSettings settings;
    std::optional<Simulation> simulation;
    TickInput input;
    TickOutput out;
    NeedleEvents events;
};

TEST(Toolbox, AToolIsTakenByCommandInTheTickThatPopsIt) {
    ToolBench b;
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::needle);
    EXPECT_FALSE(b.out.tool_force.event);
    b.take(Tool::finger);
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
    EXPECT_TRUE(b.out.tool_force.event);
    b.take(Tool::finger);  // already selected
    b.to(-0.005);
    EXPECT_FALSE(b.out.tool_force.event);
    b.command(CommandKind::tool, 77);  // no such tool
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
}

TEST(Toolbox, ANeedleInTheBodyIsDrawnOutBeforeAnotherToolIsTaken) {
    ToolBench b;
    b.to(-0.005);
    b.sweep(0.010);
    b.take(Tool::finger);
    b.to(0.010);
    EXPECT_EQ(b.out.tool, Tool::needle);
    EXPECT_NEAR(b.out.force_n, 0.7, 1e-9);
    b.take(Tool::guide);  // the guide uses the same needle
    b.to(0.010);
    EXPECT_EQ(b.out.tool, Tool::guide);
    EXPECT_NEAR(b.out.force_n, 0.7, 1e-9);
    b.sweep(-0.005);
    b.take(Tool::finger);
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
}

// HZ-FORCE-05
TEST(Toolbox, ANeedleTakenUpInsideTheBodyIsNotFeltUntilItHasBeenOutside) {
    ToolBench b(0.0, Tool::scalpel);
    b.to(0.010);
    b.take(Tool::needle);
    b.to(0.010);
    b.sweep(0.020);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.sweep(-0.005);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::held);
    EXPECT_LT(b.out.tool_force.force_n.x, 0.0);
}

// Tools that are not in hand are not hashed. Two different needles, both put down, and the same finger give
// equal hashes.
TEST(Toolbox, AnIdleNeedleIsNotHashed) {
    ToolState a, b;
    a.in_hand = b.in_hand = Tool::needle;
    b.needle.force_n = 0.5, b.needle.depth_m = 0.01;
    const auto hashOf = [](const ToolState& s) {
        StateHash hash;
        hashTools(hash, s);
        return hash.value();
    };
    EXPECT_NE(hashOf(a), hashOf(b));
    a.in_hand = b.in_hand = Tool::finger;
    EXPECT_EQ(hashOf(a), hashOf(b));
    b.finger.pad.depth_m = 0.001;
    EXPECT_NE(hashOf(a), hashOf(b));
}

TEST(Toolbox, TheGainIsSetByTheSteepestTool) {
    const patient::TissueTable& table = test::tissueDefaults().tissues;
    ToolSettings s;
    EXPECT_EQ(worstTangent(table, s), 2400.0);  // the probe on bone, with sticking proxies
    s.probe.pad.shear_n_per_m = 0.0;
    EXPECT_EQ(worstTangent(table, s), 2300.0);  // the finger on bone
    s.finger.pad.shear_n_per_m = 0.0;
    EXPECT_EQ(worstTangent(table, s), 2000.0);  // the needle on bone
    s.guide.stiffness_n_per_m = 2500.0;
    EXPECT_EQ(worstTangent(table, s), 2500.0);
    s.scalpel.stiffness_n_per_m = 2600.0;
    EXPECT_EQ(worstTangent(table, s), 2600.0);
}

TEST(Toolbox, EverySettingIsHashed) {
    const auto hashOf = [](const ToolSettings& s) {
        StateHash hash;
        hashToolSettings(hash, s);
        return hash.value();
    };
    std::set<std::uint64_t> hashes{hashOf({})};
    std::size_t settings = 0;
    ToolSettings s;
    eachToolNumber(s, [&](double& v) {
        const double was = v;
        v += 0.125;
        hashes.insert(hashOf(s));
        v = was, ++settings;
    });
    eachToolCount(s, [&](int& v) {
        ++v;
        hashes.insert(hashOf(s));
        --v, ++settings;
    });
    s.first = Tool::probe;
    hashes.insert(hashOf(s));
    EXPECT_EQ(settings, 5u + 13u + 5u + 1u + 6u + 2u + 8u);
    EXPECT_EQ(hashes.size(), settings + 2);
}

TEST(Toolbox, AnIdleNeedleKeepsItsCuts) {
    ToolBench b;
    b.to(-0.005);
    b.sweep(0.010);
    b.sweep(-0.005);
    const int cuts = b.simulation->state().tools.needle.cut_count;
    EXPECT_GT(cuts, 0);
    b.take(Tool::finger);
    b.to(-0.005);
    b.take(Tool::needle);
    b.to(-0.006);
    EXPECT_EQ(b.simulation->state().tools.needle.cut_count, cuts);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::pass);  // through the same hole
}

// A needle put down on one side and picked up on the other has not passed through the patient.
TEST(Toolbox, ANeedleTakenUpElsewhereHasNotGoneThere) {
    ToolBench b;
    b.to(-0.005);
    b.take(Tool::finger);
    b.to(-0.005);
    b.to({-0.005, 0.1, 0.0}), b.to({0.060, 0.1, 0.0}), b.to({0.060, 0.0, 0.0});
    b.take(Tool::needle);
    b.to(0.060);
    EXPECT_EQ(b.events.count, 0);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.simulation->state().tools.needle.cut_count, 0);
}

// The device reports a wrong position for one tick: within its reach, behind the patient.
// HZ-FORCE-05
TEST(Toolbox, ALeapOutsideIsNoWayThroughThePatient) {
    ToolBench b;
    b.to(-0.005);
    for (const double x_m : {0.060, -0.005}) {
        b.to(x_m);
        EXPECT_EQ(b.events.count, 0) << x_m;
        EXPECT_EQ(b.out.phase, Phase::outside) << x_m;
    }
    EXPECT_EQ(b.simulation->state().tools.needle.cut_count, 0);
    b.to(0.020);  // into the middle of the body: no force until the needle was outside
    b.sweep(0.022);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.sweep(-0.005);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::held);
}

// HZ-FORCE-05
TEST(Toolbox, ALeapOfANeedleInTheBodyIsNotBelieved) {
    ToolBench b;
    b.to(-0.005);
    b.sweep(0.010);
    const double force_n = b.out.force_n, depth_m = b.out.depth_m;
    b.to(0.050);
    EXPECT_EQ(b.events.count, 0);
    EXPECT_EQ(b.out.depth_m, depth_m);
    b.to(0.010), b.to(0.010);
    EXPECT_EQ(b.out.depth_m, depth_m);
    EXPECT_NEAR(b.out.force_n, force_n, 1e-9);
}

// HZ-FORCE-05
TEST(Toolbox, ANeedleThatBeginsInsideIsNotFelt) {
    ToolBench b;
    b.to(0.010);
    b.sweep(0.012);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
}

TEST(Toolbox, GasInTheBodyIsNotOutside) {
    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.018}, {air, 0.010}, {soft, 0.02}});
    patient::Label lung;
    lung.id = 40, lung.name = "lung", lung.tissue = air;
    package.label_table.push_back(lung);
    for (std::size_t i = 200; i < 300; ++i)
        package.labels.voxels[i] = lung.id;
    ToolBench b(package, Tool::scalpel);
    b.to(0.025);
    b.take(Tool::needle);
    b.to(0.025);
    b.sweep(0.035);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
}

TEST(Toolbox, ACommandThatDoesNothingIsNoEvent) {
    ToolBench b;
    b.to(-0.005);
    for (const std::uint32_t stay : {0u, 1u}) {  // no probe is in hand, and none is parked
        b.command(CommandKind::park, stay);
        b.to(-0.005);
        EXPECT_FALSE(b.out.tool_force.event) << stay;
    }
}

// Breathing moves probe and rail along z. The needle, beside the rail, leans in the same direction.
TEST(Toolbox, ARailThatMovesMovesWhatTheHandFeelsOfIt) {
    ToolBench b(-0.012, Tool::probe);
    b.to(-0.001);
    b.command(CommandKind::park, 1);
    b.to(-0.001);
    b.take(Tool::guide);
    const double half = 0.5 * 0.3;
    b.input.device.device_from_stylus = {Quat{std::cos(half), 0.0, std::sin(half), 0.0} * test::kAlongX,
                                         {-0.05, 0.1, 0.0}};
    const auto still = [&] {
        b.simulation->step(b.input, b.out, b.events);
        b.input.command_count = 0;
    };
    still();
    Vec3 before = b.out.patient_from_probe.position_m;
    double moved_m = 0.0;
    for (int i = 0; i < 1000; ++i) {
        still();
        const Vec3 now = b.out.patient_from_probe.position_m;
        ASSERT_LT(glm::length(b.out.tool_force.tissue_moved_m - (now - before)), 1e-12) << i;
        moved_m += glm::length(now - before);
        before = now;
    }
    EXPECT_GT(moved_m, 0.002);
}

TEST(Toolbox, TheSameTicksWithAnotherToolEndInAnotherHash) {
    ToolBench a, b(0.0, Tool::finger);
    for (int i = 0; i < 10; ++i)
        a.to(-0.005), b.to(-0.005);
    EXPECT_NE(a.out.state_hash, b.out.state_hash);
}

TEST(Toolbox, AParkedProbeRidesTheBreath) {
    ToolBench b(-0.012, Tool::probe);
    b.to({-0.001, 0.0, 0.010});
    b.command(CommandKind::park, 1);
    b.to({-0.001, 0.0, 0.010});
    EXPECT_TRUE(b.out.probe_parked);
    EXPECT_NEAR(b.out.patient_from_probe.direction({0.0, 0.0, 1.0}).x, 1.0, 1e-12);  // +z into the body
    const Vec3 before = b.out.patient_from_probe.position_m;
    double most_m = 0.0;
    for (int i = 0; i < 4000; ++i) {
        b.to(-0.05);
        most_m = std::max(most_m, before.z - b.out.patient_from_probe.position_m.z);
    }
    EXPECT_NEAR(most_m, 0.012, 1e-4);
    EXPECT_NEAR(b.out.patient_from_probe.position_m.z, before.z, 1e-4);
    b.take(Tool::needle);
    b.command(CommandKind::park, 1);  // the probe is not in hand
    b.to(-0.05);
    EXPECT_TRUE(b.out.probe_parked);
    b.command(CommandKind::park, 0);
    b.to(-0.05);
    EXPECT_FALSE(b.out.probe_parked);
}

TEST(Toolbox, AProbeLetGoOfLeavesTheHandEmpty) {
    const patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.030}}, 0.001);
    const patient::Patient patient(package);
    const TouchMap map = makeTouchMap(patient, patient::makeSkin(patient, 2), 2);
    SimulationSettings settings;
    settings.tools.first = Tool::probe;
    Simulation simulation(patient, settings, &map);
    TickInput input;
    TickOutput out;
    NeedleEvents events;
    const auto to = [&](double x_m) {
        input.device.device_from_stylus = {test::kAlongX, {x_m, 0.0, 0.0}};
        simulation.step(input, out, events);
        input.command_count = 0;
    };
    const auto park = [&](std::uint32_t stay) {
        input.commands[0] = {CommandKind::park, stay};
        input.command_count = 1;
    };
    for (int i = 0; i <= 300; ++i)
        to(-0.010 + 0.00004 * i);
    EXPECT_LT(out.tool_force.force_n.x, -0.05);
    park(1), to(0.002);
    EXPECT_TRUE(out.probe_parked && out.tool_force.event);
    EXPECT_EQ(out.tool_force.force_n, Vec3(0.0));
    park(0), to(0.002);  // in hand again, inside the body
    EXPECT_FALSE(out.probe_parked);
    EXPECT_EQ(out.tool_force.force_n, Vec3(0.0));
    for (int i = 0; i < 300; ++i)
        to(0.002 - 0.00004 * i);
    for (int i = 0; i <= 300; ++i)
        to(-0.010 + 0.00004 * i);
    EXPECT_LT(out.tool_force.force_n.x, -0.05);
}

// The rail points along the needle's path. A needle pushed sideways in it does not move within the tissue.
TEST(Toolbox, InTheGuideTheHandFeelsTheRailAndTheNeedleStaysOnIt) {
    ToolBench b(0.0, Tool::probe);
    b.settings.tools.guide.probe_from_guide = {{0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, -0.002}};
    b.simulation.emplace(b.patient, b.settings);
    b.to(-0.001);
    b.command(CommandKind::park, 1);
    b.to(-0.001);
    b.take(Tool::guide);
    b.to(-0.02);
    EXPECT_TRUE(b.out.needle_in_guide);
    b.take(Tool::needle);
    b.to(-0.02);
    b.sweep(0.010);
    EXPECT_TRUE(b.out.needle_in_guide);
    for (int i = 1; i <= 40; ++i)
        b.to({0.010, 0.0003 + 1e-4 * i, 0.0002});
    EXPECT_NEAR(b.out.tool_force.force_n.y, -1000.0 * 0.004, 1e-9);
    EXPECT_NEAR(b.out.tool_force.force_n.x, -0.7, 1e-9);
    const double crest_j = 0.5 * 1000.0 * 0.0015 * 0.006;  // energy is counted from outside the rail's reach
    EXPECT_NEAR(b.out.tool_force.energy_j, 0.5 * 1000.0 * 0.004 * 0.004 - crest_j + 0.5 * 0.7 * 0.7 / 1000.0,
                1e-9);
    EXPECT_NEAR(b.out.patient_from_needle.position_m.y, 0.0003, 1e-12);
    EXPECT_EQ(b.out.lateral_cut_m, 0.0);
    b.command(CommandKind::park, 0);  // rejected while the needle is in the body: it would jump to the hand
    b.to({0.010, 0.0043, 0.0002});
    EXPECT_TRUE(b.out.probe_parked && b.out.needle_in_guide);
    EXPECT_FALSE(b.out.tool_force.event);
    EXPECT_EQ(b.out.lateral_cut_m, 0.0);
    for (int i = 39; i >= 0; --i)
        b.to({0.010, 0.0003 + 1e-4 * i, 0.0002});
    b.sweep(-0.02);
    b.command(CommandKind::park, 0);  // the probe is taken away and the needle follows the hand
    b.to(-0.02);
    EXPECT_TRUE(b.out.tool_force.event);
    EXPECT_FALSE(b.out.needle_in_guide);
}

}  // namespace
}  // namespace stylet::haptics
