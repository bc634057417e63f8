#include "haptics/loop/access.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "haptics/loop/simulation.h"
#include "tests/haptics/along_x.h"
#include "tests/haptics/column.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum patient::Tissue;

// Layers with a wide duct at x = 12 to 18 mm.
patient::Package layers(double breath_m) {
    patient::Package package =
        test::makeSlabs({{skin, 0.002}, {soft, 0.004}, {liver, 0.006}, {duct, 0.006}, {liver, 0.020}}, 0.001);
    if (breath_m != 0.0) test::addBreathing(package, breath_m);
    return package;
}

// A hand that moves along the needle's axis. The needle is tilted by `tilt_deg` from the layers' normal, and
// its entry is beside the middle, so that the wire has a long way in the layer.
struct AccessBench {
    explicit AccessBench(double tilt_deg, double breath_m = 0.0, const SimulationSettings& settings = {})
        : package(layers(breath_m)), simulation(patient, settings, nullptr, &ducts) {
        const double tilt_rad = tilt_deg * 0.017453292519943295;
        rotation = glm::angleAxis(tilt_rad, Vec3(0.0, 0.0, 1.0)) * test::kAlongX;
        axis = rotation * Vec3(0.0, 0.0, -1.0);
        entry_m = {0.0, tilt_deg > 0.0 ? -0.0185 : 0.0005, 0.0003};
        to(-0.020);
    }
    void to(double depth_m) {
        depth = depth_m;
        input.device.device_from_stylus = {rotation, entry_m + depth_m * axis};
        simulation.step(input, out, events);
        input.command_count = 0;
        peak_n = std::max(peak_n, glm::length(out.tool_force.force_n));
    }
    void sweep(double depth_m) {
        while (std::fabs(depth_m - depth) > 1e-9)
            to(depth + std::clamp(depth_m - depth, -0.00005, 0.00005));
    }
    void by(double travel_m) { sweep(depth + travel_m); }
    Tool select(Tool tool) {
        input.add({CommandKind::tool, std::uint32_t(tool)});
        to(depth);
        return out.tool;
    }
    // Depth at which the tip is in the middle of the duct.
    double middle_m() const { return (0.015 - entry_m.x) / axis.x; }

    patient::Package package;
    patient::Patient patient{package};
    patient::DuctSpace ducts = patient::makeDuctSpace(patient);
    Simulation simulation;
    Quat rotation;
    Vec3 axis{0.0}, entry_m{0.0};
    double depth = 0.0, peak_n = 0.0;
    TickInput input;
    TickOutput out;
    NeedleEvents events;
};

constexpr double kTilt_deg = 50.0;

TEST(Access, TheWholeChainPlacesADrain) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    EXPECT_EQ(b.out.tissue, duct);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(0.018);
    EXPECT_TRUE(b.out.access.tip_in_duct);
    EXPECT_GT(b.out.access.in_duct_m, 0.016);
    EXPECT_FALSE(b.out.access.buckled);
    const double wire_m = b.out.access.wire_m;

    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    b.by(-0.090);
    EXPECT_FALSE(b.out.access.needle_in);
    EXPECT_TRUE(b.out.access.wire_in);
    EXPECT_EQ(b.out.access.wire_m, wire_m);
    EXPECT_EQ(b.out.phase, Phase::outside);

    ASSERT_EQ(b.select(Tool::dilator), Tool::dilator);
    const double track_m = glm::distance(b.out.access.entry_m, b.out.access.base_m);
    b.peak_n = 0.0;
    b.by(track_m + 0.005);
    EXPECT_GT(b.peak_n, 1.0);
    EXPECT_NEAR(b.out.access.dilated_m, track_m - 0.015, 0.008);
    EXPECT_EQ(b.select(Tool::drain), Tool::dilator) << "the dilator is in the body";
    b.by(-track_m - 0.030);

    ASSERT_EQ(b.select(Tool::drain), Tool::drain);
    b.by(track_m + 0.012);
    EXPECT_EQ(b.out.access.drain, DrainState::over_wire);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(-track_m - 0.060);
    EXPECT_EQ(b.out.access.drain, DrainState::in_place);
    EXPECT_GT(b.out.access.holes_in_duct, 0.3);
    EXPECT_FALSE(b.out.access.open);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    EXPECT_EQ(b.select(Tool::finger), Tool::finger);
    EXPECT_EQ(b.out.access.drain, DrainState::in_place);
}

// A bench whose drain lies in the duct, the wire drawn out.
struct Drained : AccessBench {
    Drained() : AccessBench(kTilt_deg) {
        sweep(middle_m());
        select(Tool::wire), by(0.018);
        select(Tool::needle), by(-0.090);
        track_m = glm::distance(out.access.entry_m, out.access.base_m);
        select(Tool::drain), by(track_m + 0.012);
        select(Tool::wire), by(-track_m - 0.060);
    }
    double track_m = 0.0;
};

TEST(Access, AWireThroughTheDrainStraightensIt) {
    Drained b;
    ASSERT_EQ(b.out.access.drain, DrainState::in_place);
    ASSERT_FALSE(b.out.access.open);
    const double drain_m = b.out.access.drain_m;
    EXPECT_EQ(b.select(Tool::drain), Tool::wire) << "nothing straightens it";
    ASSERT_EQ(b.select(Tool::wire), Tool::wire) << "it was in the hand already";
    EXPECT_TRUE(b.out.access.open && b.out.access.wire_in);
    EXPECT_LT(b.out.access.wire_m, 0.006 - b.track_m) << "just inside the skin";
    b.by(drain_m - 0.025);
    EXPECT_EQ(b.out.access.drain, DrainState::in_place);
    EXPECT_EQ(b.select(Tool::drain), Tool::wire) << "the loop is not straight yet";
    b.by(0.022);
    EXPECT_EQ(b.out.access.drain, DrainState::over_wire);
    EXPECT_EQ(b.out.access.drain_m, drain_m);
    ASSERT_EQ(b.select(Tool::drain), Tool::drain);
    b.by(-0.014);  // the hand still pushed
    EXPECT_LT(b.out.access.drain_m, drain_m - 0.002);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(-b.track_m - 0.060);
    EXPECT_EQ(b.out.access.drain, DrainState::in_place);
    EXPECT_FALSE(b.out.access.open);
}

TEST(Access, AMisplacedDrainMovesOnlyOverTheWireToo) {
    ToolState tools;
    tools.active_tool = Tool::wire;
    tools.access.open = tools.access.wire_in = true;
    tools.access.drain.depth_m = 0.1;
    for (const DrainState state : {DrainState::misplaced, DrainState::in_place}) {
        tools.access.drain_state = state;
        EXPECT_FALSE(selectTool(tools, Tool::drain)) << int(state);
    }
    tools.access.drain_state = DrainState::over_wire;
    EXPECT_TRUE(selectTool(tools, Tool::drain));
}

// Into the drain and out again without reaching its loop: nothing has moved.
TEST(Access, AWireThatDoesNotReachTheDrainsLoopMovesNothing) {
    Drained b;
    const double drain_m = b.out.access.drain_m;
    b.select(Tool::wire), b.by(0.005), b.by(-0.040);
    EXPECT_FALSE(b.out.access.open);
    EXPECT_EQ(b.out.access.drain, DrainState::in_place);
    EXPECT_EQ(b.out.access.drain_m, drain_m);
    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    EXPECT_EQ(b.select(Tool::wire), Tool::wire) << "from any other tool";
    EXPECT_TRUE(b.out.access.open);
}

// A device whose travel is shorter than the wire. While the hand has let go, the wire stays and gives no
// force.
TEST(Access, AShortTravelDrawsTheWireOutByRegripping) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    b.select(Tool::wire), b.by(0.018);
    b.select(Tool::needle), b.by(-0.090);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    constexpr double kTravel_m = 0.010;
    int grips = 0;
    const double near = b.depth;
    const auto grip = [&](std::uint32_t grips_it) {
        b.input.add({CommandKind::grip, grips_it});
        b.to(b.depth);
    };
    for (; b.out.access.open && grips < 20; ++grips) {
        const double wire_m = b.out.access.wire_m;
        b.sweep(near - kTravel_m);
        if (!b.out.access.open) break;
        EXPECT_LT(b.out.access.wire_m, wire_m - 0.5 * kTravel_m);
        const double held_m = b.out.access.wire_m;
        grip(0);
        b.peak_n = 0.0;
        b.sweep(near);
        EXPECT_EQ(b.out.access.wire_m, held_m);
        EXPECT_EQ(b.peak_n, 0.0);
        grip(1);
    }
    EXPECT_FALSE(b.out.access.open) << "the wire is out";
    EXPECT_GT(grips, 1);
    EXPECT_LT(grips, 20);
}

TEST(Access, ALeapDoesNotGripForAHandThatHasLetGo) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    b.select(Tool::wire), b.by(0.018);
    const double wire_m = b.out.access.wire_m;
    b.input.add({CommandKind::grip, 0});
    b.to(b.depth);
    b.to(b.depth - 0.050);  // in one tick
    b.by(0.030);
    EXPECT_EQ(b.out.access.wire_m, wire_m);
    b.input.add({CommandKind::grip, 1});
    b.to(b.depth);
    b.by(-0.005);
    EXPECT_LT(b.out.access.wire_m, wire_m - 0.003);
}

TEST(Access, LettingGoOfNothingChangesNothing) {
    AccessBench a(0.0), b(0.0);
    for (AccessBench* bench : {&a, &b})
        bench->sweep(0.004);
    b.input.add({CommandKind::grip, 0});
    a.input.add({CommandKind::marker, 0});
    a.to(a.depth), b.to(b.depth);
    EXPECT_EQ(a.out.tool_force.force_n, b.out.tool_force.force_n);
    b.sweep(0.008), a.sweep(0.008);
    EXPECT_EQ(a.out.tool_force.force_n, b.out.tool_force.force_n);
    EXPECT_EQ(a.out.depth_m, b.out.depth_m);
}

// Taking the wire for a moment does not hide what the needle punctures afterwards.
TEST(Access, PuncturesAfterALaidDownWireAreReported) {
    AccessBench b(0.0);
    b.sweep(0.004);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    int punctures = 0;
    while (b.depth < b.middle_m()) {
        b.to(b.depth + 0.00005);
        for (const NeedleEvent& event : b.events.all())
            punctures += event.kind == NeedleEventKind::puncture && event.border.to == duct;
    }
    EXPECT_EQ(b.out.tissue, duct);
    EXPECT_EQ(punctures, 1);
}

// The wire comes out of the needle's tip, wherever the needle was moved since the wire was last taken.
TEST(Access, WireTakenAgainBeginsAtTheNeedlesTip) {
    AccessBench b(0.0);
    b.sweep(0.008);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    b.sweep(b.middle_m());
    const Vec3 tip_m = b.out.patient_from_needle.position_m;
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(0.0005);
    EXPECT_NEAR(glm::distance(b.out.access.base_m, tip_m), 0.0, 1e-4);
    EXPECT_NEAR(glm::distance(b.out.patient_from_needle.position_m, tip_m), 0.0, 1e-4);
}

TEST(Access, NeedleThatDentsTheSkinIsNotIn) {
    AccessBench b(0.0);
    b.sweep(0.0004);
    ASSERT_EQ(b.out.phase, Phase::tenting);
    EXPECT_EQ(b.select(Tool::wire), Tool::needle);
}

TEST(Access, WrongOrdersAreRefused) {
    AccessBench b(kTilt_deg);
    for (const Tool tool : {Tool::wire, Tool::dilator, Tool::drain})
        EXPECT_EQ(b.select(tool), Tool::needle) << "no needle in the body";
    b.sweep(b.middle_m());
    EXPECT_EQ(b.select(Tool::dilator), Tool::needle);
    EXPECT_EQ(b.select(Tool::finger), Tool::needle);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(0.015);
    for (const Tool tool :
         {Tool::finger, Tool::probe, Tool::scalpel, Tool::guide, Tool::dilator, Tool::drain})
        EXPECT_EQ(b.select(tool), Tool::wire) << "the needle is in the body";
    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    b.by(-0.090);
    ASSERT_EQ(b.select(Tool::dilator), Tool::dilator);
    EXPECT_EQ(b.select(Tool::needle), Tool::dilator) << "the wire holds the access";
    EXPECT_EQ(b.select(Tool::scalpel), Tool::scalpel);
    EXPECT_TRUE(b.out.access.wire_in);
    EXPECT_EQ(b.select(Tool::wire), Tool::wire);
}

TEST(Access, ANeedleWithdrawnWithoutAWireLosesTheAccess) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(-0.005);  // behind the needle's tip
    ASSERT_EQ(b.select(Tool::needle), Tool::needle);
    EXPECT_FALSE(b.out.access.wire_in);
    b.by(-0.090);
    EXPECT_FALSE(b.out.access.open);
    EXPECT_EQ(b.select(Tool::dilator), Tool::needle);
    EXPECT_EQ(b.select(Tool::finger), Tool::finger);
}

TEST(Access, AWireThatIsPulledOutLosesTheAccess) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    b.select(Tool::wire);
    b.by(0.015);
    b.select(Tool::needle);
    b.by(-0.090);
    ASSERT_EQ(b.select(Tool::wire), Tool::wire);
    b.by(-0.100);
    EXPECT_FALSE(b.out.access.open);
    EXPECT_FALSE(b.out.access.wire_in);
    EXPECT_EQ(b.out.tool_force.force_n, Vec3(0.0));
    EXPECT_EQ(b.select(Tool::dilator), Tool::wire);
    EXPECT_EQ(b.select(Tool::needle), Tool::needle);
}

// The wire meets the far wall of the duct head-on.
TEST(Access, AtARightAngleTheWireBuckles) {
    AccessBench b(0.0);
    b.sweep(b.middle_m());
    b.select(Tool::wire);
    b.by(0.040);
    EXPECT_TRUE(b.out.access.buckled || b.out.access.pierced);
    EXPECT_LT(b.out.access.wire_m, 0.012);
}

// The needle's tip is still in the liver.
TEST(Access, InParenchymaTheForceRisesAndTheWireStays) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m() - 0.013);
    EXPECT_EQ(b.out.tissue, liver);
    b.select(Tool::wire);
    b.peak_n = 0.0;
    b.by(0.040);
    EXPECT_LT(b.out.access.wire_m, 0.008);
    EXPECT_FALSE(b.out.access.tip_in_duct);
    EXPECT_GT(b.peak_n, 1.9);
    EXPECT_TRUE(b.out.access.buckled);
}

TEST(Access, BruteForceMovesNothing) {
    AccessBench b(kTilt_deg);
    b.sweep(b.middle_m());
    b.select(Tool::wire);
    const double wire_m = b.out.access.wire_m;
    for (int i = 0; i < 10; ++i)
        b.to(b.depth + 0.010);  // 10 m/s: a leap
    EXPECT_EQ(b.out.access.wire_m, wire_m);
    for (int i = 0; i < 200; ++i)
        b.to(b.depth + 0.0009);
    EXPECT_LE(b.peak_n, 10.0);
    EXPECT_LE(b.out.access.wire_m, kMaxWire_m);
}

// The assistant's needle moves with the tissue while the hand rests.
TEST(Access, TheHeldNeedleFollowsTheBreath) {
    AccessBench b(kTilt_deg, 0.010);
    b.input.add({CommandKind::holdBreath, 0});
    for (int i = 0; i < 5000; ++i)
        b.to(-0.020);
    b.sweep(b.middle_m());
    b.select(Tool::wire);
    const Vec3 before_m = b.out.patient_from_needle.position_m, reference_m = b.out.tip_reference_m;
    b.input.add({CommandKind::breathe, 0});
    double moved_m = 0.0;
    for (int i = 0; i < 4000; ++i) {
        b.to(b.depth);
        moved_m = std::max(moved_m, glm::distance(b.out.patient_from_needle.position_m, before_m));
        ASSERT_LT(glm::distance(b.out.tip_reference_m, reference_m), 0.0005);
    }
    EXPECT_GT(moved_m, 0.005);
    EXPECT_EQ(b.select(Tool::needle), Tool::needle);
    b.by(-0.090);
    EXPECT_EQ(b.out.phase, Phase::outside);
}

// The hash of an attempt without a wire does not depend on the wire's settings or on the ducts.
TEST(Access, IsHashedFromTheFirstWireOn) {
    SimulationSettings other;
    other.tools.access.wire.drag_n_per_m = 0.7;
    AccessBench a(kTilt_deg), b(kTilt_deg, 0.0, other), c(kTilt_deg);
    for (AccessBench* bench : {&a, &b, &c})
        bench->sweep(bench->middle_m());
    EXPECT_EQ(a.out.state_hash, b.out.state_hash);
    for (AccessBench* bench : {&a, &b, &c}) {
        bench->select(Tool::wire);
        bench->by(0.015);
    }
    EXPECT_NE(a.out.state_hash, b.out.state_hash);
    EXPECT_EQ(a.out.state_hash, c.out.state_hash);
}

TEST(Access, EverySettingIsInTheDigest) {
    AccessSettings s;
    const std::uint64_t before = digest(s);
    int count = 0;
    visitAccessNumbers(s, [&](double& v) {
        const double was = v;
        v += 0.125;
        EXPECT_NE(digest(s), before);
        v = was, ++count;
    });
    EXPECT_EQ(count, 11 + 7 + 7);
}

}  // namespace
}  // namespace stylet::haptics
