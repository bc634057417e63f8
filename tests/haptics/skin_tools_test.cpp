// Finger, probe and scalpel in the simulation: selected by command, felt, and hashed.
#include <gtest/gtest.h>

#include "tests/haptics/simulation_bench.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum patient::Tissue;

patient::Package makeThreeSlabs(double travel_m) {
    patient::Package package = test::makeSlabs({{skin, 0.002}, {soft, 0.012}, {liver, 0.046}}, 0.001);
    if (travel_m != 0.0) package.motion = test::makeShift(travel_m);
    return package;
}

// Starts 20 mm above the skin.
struct SkinToolBench : test::SimulationBench {
    explicit SkinToolBench(Tool first, bool with_skin = true, double travel_m = 0.0)
        : SimulationBench(makeThreeSlabs(travel_m), test::startWith(first), with_skin) {
        to({-0.02, 0.0, 0.0});
    }
    void sweep(const Vec3& tip_m) {
        const Vec3 from = input.device.device_from_stylus.position_m;
        const int steps = 1 + int(glm::length(tip_m - from) / 5e-5);
        for (int i = 1; i <= steps; ++i)
            to(from + (tip_m - from) * (double(i) / steps));
    }
    // Moves away from the skin and selects another tool there.
    void take(Tool tool) {
        sweep({-0.02, 0.0, 0.0});
        select(tool);
        to({-0.02, 0.0, 0.0});
    }
};

TEST(SkinTools, GiveForceOnceSelected) {
    SkinToolBench t(Tool::needle);
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel}) {
        t.take(tool);
        EXPECT_EQ(t.out.tool, tool);
        EXPECT_EQ(t.out.tool_force.force_n, Vec3(0.0));
        t.sweep({0.004, 0.0, 0.0});
        EXPECT_LT(t.out.tool_force.force_n.x, -0.05) << int(tool);
        EXPECT_GT(t.out.tool_force.energy_j, 0.0);
        EXPECT_LT(t.out.sent_device_n.x, 0.0);
    }
    SkinToolBench without(Tool::finger, false);
    without.sweep({0.004, 0.0, 0.0});
    EXPECT_EQ(without.out.tool_force.force_n, Vec3(0.0));
}

TEST(SkinTools, NeedlePassesAnIncisionWithoutPuncture) {
    SkinToolBench whole(Tool::needle);
    whole.sweep({0.0005, 0.0, 0.001});
    EXPECT_EQ(whole.out.phase, Phase::tenting);
    EXPECT_NEAR(whole.out.force_n, 0.3143, 1e-3);  // puncture needs 0.7 N at 0.875 mm (Eq. 1)

    SkinToolBench cut(Tool::scalpel);
    cut.sweep({0.004, 0.0, 0.0});
    cut.take(Tool::needle);
    cut.sweep({0.0005, 0.0, 0.001});
    EXPECT_EQ(cut.out.phase, Phase::pass);
    EXPECT_LE(cut.out.force_n, 0.7);
}

TEST(SkinTools, IncisionBeyondTheListReportsOverflow) {
    SkinToolBench t(Tool::scalpel);
    for (int i = 0; i < kMaxIncisions + 2; ++i) {
        const double z_m = 0.004 * (i - 4.5);
        int overflows = 0;
        t.sweep({-0.002, 0.0, z_m});
        for (double x_m = -0.002; x_m < 0.002; x_m += 5e-5) {
            t.to({x_m, 0.0, z_m});
            for (const NeedleEvent& e : t.events.all())
                overflows += e.kind == NeedleEventKind::overflow;
        }
        EXPECT_TRUE(t.simulation.state().tools.scalpel.cutting);
        EXPECT_EQ(overflows, i < kMaxIncisions ? 0 : 1) << i;
        t.sweep({-0.002, 0.0, z_m});
    }
    EXPECT_EQ(t.simulation.state().tools.incisions.count, kMaxIncisions);
}

TEST(SkinTools, ParkedProbeFollowsTheSkinInTheTick) {
    SkinToolBench t(Tool::probe, true, -0.010);
    t.sweep({0.003, 0.0, 0.0});
    EXPECT_GT(t.out.probe_touching_share, 0.3);
    EXPECT_GT(t.out.probe_pressure_pa, 100.0);
    t.command(CommandKind::park, 1);
    t.to({0.003, 0.0, 0.0});
    ASSERT_TRUE(t.out.probe_parked);
    const Vec3 parked_m = t.out.patient_from_probe.position_m;
    for (int i = 0; i < 4000; ++i)  // a breath that slides the skin along under the tool
        t.to({-0.02, 0.0, 0.0});
    EXPECT_LT(glm::length(t.out.patient_from_probe.position_m - parked_m), 1e-5);
}

TEST(SkinTools, UnusedToolsDoNotChangeTheHash) {
    SkinToolBench with(Tool::needle, true), without(Tool::needle, false);
    with.sweep({0.020, 0.0, 0.0}), without.sweep({0.020, 0.0, 0.0});
    EXPECT_EQ(with.out.state_hash, without.out.state_hash);
    SkinToolBench felt(Tool::finger, true), numb(Tool::finger, false);
    felt.sweep({0.004, 0.0, 0.0}), numb.sweep({0.004, 0.0, 0.0});
    EXPECT_NE(felt.out.state_hash, numb.out.state_hash);
    SkinToolBench again(Tool::finger, true);
    again.sweep({0.004, 0.0, 0.0});
    EXPECT_EQ(felt.out.state_hash, again.out.state_hash);
}

}  // namespace
}  // namespace stylet::haptics
