#include "haptics/loop/toolbox.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/hash.h"
#include "haptics/loop/simulation.h"
#include "tests/haptics/scripted.h"
#include "tests/haptics/simulation_bench.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum Tissue;
using test::SimulationBench;
using test::startWith;

patient::Package makeThreeLayers(double travel_m = 0.0) {
    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.012}, {liver, 0.04}});
    if (travel_m != 0.0) test::addBreathing(package, travel_m);
    return package;
}

// Three layers that breathing moves by `travel_m`.
struct ToolBench : SimulationBench {
    explicit ToolBench(double travel_m = 0.0, Tool first = Tool::needle)
        : SimulationBench(makeThreeLayers(travel_m), startWith(first)) {}
};

TEST(Toolbox, ToolIsSelectedInTheTickThatPopsTheCommand) {
    ToolBench b;
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::needle);
    EXPECT_FALSE(b.out.tool_force.event);
    b.select(Tool::finger);
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
    EXPECT_TRUE(b.out.tool_force.event);
    b.select(Tool::finger);  // already selected
    b.to(-0.005);
    EXPECT_FALSE(b.out.tool_force.event);
    b.command(CommandKind::tool, 77);  // no such tool
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
}

TEST(Toolbox, NeedleMustBeWithdrawnBeforeAnotherToolIsSelected) {
    ToolBench b;
    b.to(-0.005);
    b.sweep(0.010);
    b.select(Tool::finger);
    b.to(0.010);
    EXPECT_EQ(b.out.tool, Tool::needle);
    EXPECT_NEAR(b.out.force_n, 0.7, 1e-9);
    b.select(Tool::guide);  // the guide uses the same needle
    b.to(0.010);
    EXPECT_EQ(b.out.tool, Tool::guide);
    EXPECT_NEAR(b.out.force_n, 0.7, 1e-9);
    b.sweep(-0.005);
    b.select(Tool::finger);
    b.to(-0.005);
    EXPECT_EQ(b.out.tool, Tool::finger);
}

// HZ-FORCE-05
TEST(Toolbox, NeedleSelectedInsideTheBodyGivesNoForceUntilOutside) {
    ToolBench b(0.0, Tool::scalpel);
    b.to(0.010);
    b.select(Tool::needle);
    b.to(0.010);
    b.sweep(0.020);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.sweep(-0.005);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::tenting);
    EXPECT_LT(b.out.tool_force.force_n.x, 0.0);
}

// Only the active tool is hashed. While the finger is active, states with different needles have equal
// hashes.
TEST(Toolbox, AnIdleNeedleIsNotHashed) {
    ToolState a, b;
    a.active_tool = b.active_tool = Tool::needle;
    b.needle.force_n = 0.5, b.needle.depth_m = 0.01;
    const auto hashOf = [](const ToolState& s) {
        StateHash hash;
        hashTools(hash, s);
        return hash.value();
    };
    EXPECT_NE(hashOf(a), hashOf(b));
    a.active_tool = b.active_tool = Tool::finger;
    EXPECT_EQ(hashOf(a), hashOf(b));
    b.finger.pad.depth_m = 0.001;
    EXPECT_NE(hashOf(a), hashOf(b));
}

TEST(Toolbox, StiffestToolSetsTheGain) {
    const patient::TissueTable& table = test::tissueDefaults().tissues;
    ToolSettings s;
    EXPECT_EQ(maxTangent(table, s), 2400.0);  // the probe on bone, with sticking proxies
    s.probe.pad.shear_n_per_m = 0.0;
    EXPECT_EQ(maxTangent(table, s), 2300.0);  // the finger on bone
    s.finger.pad.shear_n_per_m = 0.0;
    EXPECT_EQ(maxTangent(table, s), 2000.0);  // the needle on bone
    s.guide.stiffness_n_per_m = 2500.0;
    EXPECT_EQ(maxTangent(table, s), 2500.0);
    s.scalpel.stiffness_n_per_m = 2600.0;
    EXPECT_EQ(maxTangent(table, s), 2600.0);
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
    visitToolNumbers(s, [&](double& v) {
        const double was = v;
        v += 0.125;
        hashes.insert(hashOf(s));
        v = was, ++settings;
    });
    visitToolCounts(s, [&](int& v) {
        ++v;
        hashes.insert(hashOf(s));
        --v, ++settings;
    });
    s.first = Tool::probe;
    hashes.insert(hashOf(s));
    EXPECT_EQ(settings, 6u + 13u + 5u + 1u + 6u + 2u + 8u);
    EXPECT_EQ(hashes.size(), settings + 2);
}

TEST(Toolbox, AnIdleNeedleKeepsItsCuts) {
    ToolBench b;
    b.to(-0.005);
    b.sweep(0.010);
    b.sweep(-0.005);
    const int cuts = b.simulation.state().tools.needle.cut_count;
    EXPECT_GT(cuts, 0);
    b.select(Tool::finger);
    b.to(-0.005);
    b.select(Tool::needle);
    b.to(-0.006);
    EXPECT_EQ(b.simulation.state().tools.needle.cut_count, cuts);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::pass);  // through the same hole
}

// A needle deselected on one side and selected again on the other has not passed through the patient.
TEST(Toolbox, NeedleSelectedElsewhereCrossesNoTissue) {
    ToolBench b;
    b.to(-0.005);
    b.select(Tool::finger);
    b.to(-0.005);
    b.to({-0.005, 0.1, 0.0}), b.to({0.060, 0.1, 0.0}), b.to({0.060, 0.0, 0.0});
    b.select(Tool::needle);
    b.to(0.060);
    EXPECT_EQ(b.events.count, 0);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.simulation.state().tools.needle.cut_count, 0);
}

// For one tick the device reports a wrong position, which is within its reach and behind the patient.
// HZ-FORCE-05
TEST(Toolbox, LeapOutsideCrossesNoTissue) {
    ToolBench b;
    b.to(-0.005);
    for (const double x_m : {0.060, -0.005}) {
        b.to(x_m);
        EXPECT_EQ(b.events.count, 0) << x_m;
        EXPECT_EQ(b.out.phase, Phase::outside) << x_m;
    }
    EXPECT_EQ(b.simulation.state().tools.needle.cut_count, 0);
    b.to(0.020);  // into the middle of the body: no force until the needle was outside
    b.sweep(0.022);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.sweep(-0.005);
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::tenting);
}

struct Absence {
    const char* name;
    void (*begin)(DeviceState&);
};
constexpr Absence kAbsences[] = {
    {"lost", [](DeviceState& d) { d.flags &= ~std::uint32_t(kDeviceReady), d.fresh = 0; }},
    {"silent", [](DeviceState& d) { d.fresh = 0; }},
    {"late", [](DeviceState& d) { d.flags |= kDeviceHostLate, d.fresh = 0; }},
    {"no number", [](DeviceState& d) { d.device_from_stylus.position_m.x = std::nan(""); }},
};

// For example a controller whose tracking was lost. It is slow in the mean. HZ-FORCE-05
TEST(Toolbox, DeviceThatComesBackInTheBodyCutsNothing) {
    for (const Absence& absence : kAbsences)
        for (const bool repeats : {false, true}) {  // its last pose, before it has a new one
            SCOPED_TRACE(absence.name);
            ToolBench b;
            b.to(-0.005);
            const DeviceState before = b.input.device;
            absence.begin(b.input.device);
            b.tick(1500);
            b.input.device = before;
            if (repeats) b.tick(20);
            b.to(0.010);
            EXPECT_EQ(b.events.count, 0);
            b.sweep(0.012);
            EXPECT_EQ(b.events.count, 0);
            EXPECT_EQ(b.out.phase, Phase::outside);
            EXPECT_EQ(b.simulation.state().tools.needle.cut_count, 0);
            b.sweep(-0.005);
            b.sweep(0.0005);
            EXPECT_EQ(b.out.phase, Phase::tenting);
        }
}

// A finger leaves no cuts: it goes on wherever the device is.
TEST(Toolbox, DeviceThatComesBackWithAFingerGoesOn) {
    ToolBench b(0.0, Tool::finger);
    b.to(-0.005);
    const auto resets = b.out.tool_resets;
    b.input.device.fresh = 0;
    b.tick(1500);
    b.input.device.fresh = 1;
    b.to(0.010);
    EXPECT_EQ(b.out.tool_resets, resets);
}

TEST(Toolbox, DeviceThatComesBackWhereItWasGoesOn) {
    ToolBench b;
    b.to(-0.001);
    b.input.device.fresh = 0;
    b.tick(1500);
    b.input.device.fresh = 1;
    const auto resets = b.out.tool_resets;
    b.to(0.0005);
    EXPECT_EQ(b.out.phase, Phase::tenting);
    EXPECT_EQ(b.out.tool_resets, resets);
}

// A needle in fat, 8 mm behind the skin, with the force on.
struct LeapBench : ToolBench {
    LeapBench() {
        for (int i = 0; i < 2000; ++i)
            to(-0.005);
        sweep(0.010);
        EXPECT_EQ(out.stage, ForceStage::on);
        EXPECT_GT(sentForce(), 0.1);
        depth_m = out.depth_m;
    }
    double sentForce() const { return glm::length(out.sent_device_n); }
    // The device is at `tip_m` for `ticks`. The needle must not move, and the force must end and stay off,
    // even if the user re-arms it again and again.
    void expectLeft(const Vec3& tip_m, int ticks = 3000) {
        for (int i = 0; i < ticks; ++i) {
            if (i % 100 == 99) command(CommandKind::rearm);
            to(tip_m);
            ASSERT_EQ(events.count, 0) << i;
            ASSERT_EQ(out.depth_m, depth_m) << i;
            ASSERT_EQ(out.lateral_cut_m, 0.0) << i;
            ASSERT_TRUE(simulation.state().left_needle) << i;
            ASSERT_TRUE(i < 20 || sentForce() == 0.0) << i;
        }
    }
    void expectForceAfterRearming() {
        command(CommandKind::rearm);
        for (int i = 0; i < 2000; ++i)
            tick();
        EXPECT_EQ(out.stage, ForceStage::on);
    }
    double depth_m = 0.0;
};

// HZ-FORCE-05
TEST(Toolbox, NeedleInTheBodyIsNotSweptAlongALeapEvenIfTheDeviceStaysThere) {
    for (const Vec3& there :
         {Vec3{0.050, 0.0003, 0.0002}, Vec3{0.010, 0.0370, 0.0002}, Vec3{0.0131, 0.0003, 0.0002}}) {
        LeapBench b;
        b.expectLeft(there);
        // It comes closer slowly, but not close enough.
        const Vec3 kept{0.010, 0.0003, 0.0002};
        for (double share = 1.0; share * glm::distance(there, kept) > kRejoin_m + 1e-6; share -= 0.001)
            b.expectLeft(kept + share * (there - kept), 1);
        // Back at the needle, it moves it again, and the force returns on request.
        b.to(kept), b.to(kept);
        EXPECT_NEAR(b.out.depth_m, b.depth_m, 1e-12);
        b.expectForceAfterRearming();
        b.sweep(0.011);
        EXPECT_NEAR(b.out.depth_m, b.depth_m + 0.001, 1e-9);
    }
}

// A silent device that comes back elsewhere has a low mean speed. HZ-FORCE-05
TEST(Toolbox, LongStepAfterASilenceIsALeap) {
    LeapBench b;
    b.input.device.fresh = 0;
    for (int i = 0; i < 1000; ++i)
        b.tick();
    b.input.device.fresh = 1;
    b.expectLeft({0.050, 0.0003, 0.0002});
}

// Passing the needle at speed does not pick it up. HZ-FORCE-05
TEST(Toolbox, LeftNeedleIsNotPickedUpAtSpeed) {
    LeapBench b;
    b.expectLeft({0.050, 0.0003, 0.0002}, 100);
    for (double x_m = 0.050; x_m > -0.004; x_m -= 0.0005)
        b.expectLeft({x_m, 0.0003, 0.0002}, 1);
}

// HZ-FORCE-05
TEST(Toolbox, NeedleIsDrawnOutByADeviceThatStaysOutsideAfterALeap) {
    LeapBench b;
    b.expectLeft({-0.030, 0.0003, 0.0002}, int(kDrawnOut_s / 0.001) - 1);
    b.expectLeft({0.050, 0.0003, 0.0002}, 1);  // the time outside counts only in one piece
    b.expectLeft({-0.030, 0.0003, 0.0002}, 100);
    b.input.device.fresh = 0;  // a device that has been lost has not drawn it out
    b.expectLeft({-0.030, 0.0003, 0.0002}, 3000);
    b.input.device.fresh = 1;
    b.expectLeft({0.050, 0.0003, 0.0002}, 1);
    b.expectLeft({-0.030, 0.0003, 0.0002}, int(kDrawnOut_s / 0.001));
    b.tick();
    ASSERT_EQ(b.events.count, 1);
    EXPECT_EQ(b.events.list[0].kind, NeedleEventKind::withdrawn);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.depth_m, 0.0);
    b.expectForceAfterRearming();
    b.sweep(0.0005);
    EXPECT_EQ(b.out.phase, Phase::pass);  // through its own hole
    b.sweep(0.010);
    EXPECT_NEAR(b.out.force_n, 0.7, 1e-9);
}

// HZ-FORCE-05
TEST(Toolbox, GlitchOfOneTickLeavesTheNeedleWhereItIs) {
    LeapBench b;
    const double force_n = b.out.force_n;
    for (const double x_m : {0.050, -0.030}) {
        b.to(x_m);
        EXPECT_EQ(b.events.count, 0);
        b.to(0.010), b.to(0.010);
        EXPECT_EQ(b.out.depth_m, b.depth_m);
        EXPECT_NEAR(b.out.force_n, force_n, 1e-9);
    }
}

// HZ-FORCE-05
TEST(Toolbox, NeedleStartingInsideGivesNoForce) {
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
    SimulationBench b(package, startWith(Tool::scalpel));
    b.to(0.025);
    b.select(Tool::needle);
    b.to(0.025);
    b.sweep(0.035);
    EXPECT_EQ(b.out.phase, Phase::outside);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
}

TEST(Toolbox, CommandWithoutEffectIsNoEvent) {
    ToolBench b;
    b.to(-0.005);
    for (const std::uint32_t stay : {0u, 1u}) {  // the probe is neither active nor parked
        b.command(CommandKind::park, stay);
        b.to(-0.005);
        EXPECT_FALSE(b.out.tool_force.event) << stay;
    }
}

// Breathing moves probe and rail along z. The needle, beside the rail, leans in the same direction.
TEST(Toolbox, MovingRailCountsAsTissueMotion) {
    ToolBench b(-0.012, Tool::probe);
    b.to(-0.001);
    b.command(CommandKind::park, 1);
    b.to(-0.001);
    b.select(Tool::guide);
    const double half = 0.5 * 0.3;
    b.input.device.device_from_stylus = {Quat{std::cos(half), 0.0, std::sin(half), 0.0} * test::kAlongX,
                                         {-0.05, 0.1, 0.0}};
    b.tick();
    Vec3 before = b.out.patient_from_probe.position_m;
    double moved_m = 0.0;
    for (int i = 0; i < 1000; ++i) {
        b.tick();
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

TEST(Toolbox, ParkedProbeFollowsBreathing) {
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
    b.select(Tool::needle);
    b.command(CommandKind::park, 1);  // the probe is not active
    b.to(-0.05);
    EXPECT_TRUE(b.out.probe_parked);
    b.command(CommandKind::park, 0);
    b.to(-0.05);
    EXPECT_FALSE(b.out.probe_parked);
}

TEST(Toolbox, ParkingTheProbeLeavesTheHandEmpty) {
    SimulationBench b(test::makeSlabs({{skin, 0.002}, {soft, 0.030}}, 0.001), startWith(Tool::probe), true);
    b.to({-0.010, 0.0, 0.0});
    b.sweep(0.002);
    EXPECT_LT(b.out.tool_force.force_n.x, -0.05);
    b.command(CommandKind::park, 1);
    b.tick();
    EXPECT_TRUE(b.out.probe_parked && b.out.tool_force.event);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.command(CommandKind::park, 0);  // active again, inside the body
    b.tick();
    EXPECT_FALSE(b.out.probe_parked);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    b.sweep(-0.010);
    b.sweep(0.002);
    EXPECT_LT(b.out.tool_force.force_n.x, -0.05);
}

// The rail points along the needle's path. A needle pushed sideways in it does not move within the tissue.
TEST(Toolbox, GuidedNeedleStaysOnTheRailAndTheHandFeelsTheRail) {
    SimulationSettings settings = startWith(Tool::probe);
    settings.tools.guide.probe_from_guide = {{0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, -0.002}};
    SimulationBench b(makeThreeLayers(), settings);
    b.to(-0.001);
    b.command(CommandKind::park, 1);
    b.to(-0.001);
    b.select(Tool::guide);
    b.to(-0.02);
    EXPECT_TRUE(b.out.needle_in_guide);
    b.select(Tool::needle);
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
