#include "haptics/output/output.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using test::kDt_s;
using test::kNaN;

// Settings with a gain of 1.
OutputSettings plain() {
    OutputSettings s;
    s.model_tangent_n_per_m = 1000.0;
    return s;
}

// maxTangent() returns the steepest slope [N/m] of all force curves in the tissue table. Cartilage has the
// stiffness k = 1300 N/m. Its curve starts with the slope a1 = a1_share * k and ends at the puncture with the
// steepest slope, (2 - a1_share) * k. Bone is a linear spring of 2000 N/m.
TEST(Output, TheTangentIsTheSteepestOfTheTable) {
    const patient::TissueTable table = test::tissueDefaults().tissues;
    EXPECT_DOUBLE_EQ(maxTangent(table, {.a1_share = 0.0}), 2600.0);
    EXPECT_DOUBLE_EQ(maxTangent(table, {.a1_share = 0.5}), 2000.0);
}

// HZ-FORCE-09
TEST(Output, TheGainIsTheSmallestOfItsThreeBounds) {
    OutputSettings s;
    s.model_tangent_n_per_m = 2000.0;
    s.model_force_n = 22.0;
    EXPECT_DOUBLE_EQ(outputGain({"stiff", 22.0, 4000.0, ""}, s), 1.0);
    EXPECT_DOUBLE_EQ(outputGain({"soft", 22.0, 1000.0, ""}, s), 0.5);
    EXPECT_DOUBLE_EQ(outputGain({"weak", 3.3, 4000.0, ""}, s), 0.15);
    EXPECT_DOUBLE_EQ(outputGain({"unknown", kNaN, kNaN, ""}, s), 3.3 / 22.0);
}

// An output stage after its start ramp, at full force.
struct Stage {
    explicit Stage(const OutputSettings& s = plain(), const DeviceProfile& p = {}, double g = 1.0)
        : settings(s), profile(p), gain(g) {
        hold(Vec3(0.0), 1600);
        EXPECT_EQ(state.safety.level, 1.0);
    }
    Vec3 send(const Vec3& force_n) {
        tick.tool.force_n = force_n;
        return stepOutput(state, settings, profile, gain, tick, kDt_s);
    }

    void hold(const Vec3& force_n, int ticks) {
        for (; ticks > 0; --ticks)
            send(force_n);
    }

    OutputSettings settings;
    DeviceProfile profile;
    double gain;
    OutputState state;
    OutputTick tick;
};

// HZ-FORCE-04
TEST(Output, TheRateLimitIsReachedAndHeld) {
    Stage stage;
    const Vec3 wanted{3.0, 4.0, 0.0};
    Vec3 sent = stage.send(wanted);
    EXPECT_NEAR(sent.x, 1.2, 1e-12);  // 2 N of the 5 N, in the same direction
    EXPECT_NEAR(sent.y, 1.6, 1e-12);
    EXPECT_TRUE(stage.state.limited);
    stage.send(wanted);
    sent = stage.send(wanted);
    EXPECT_EQ(sent, wanted);
    EXPECT_FALSE(stage.state.limited);
}

TEST(Output, FasciaPunctureDropPassesInOneTick) {
    Stage stage;
    stage.state.model_n = {2.5, 0.0, 0.0};
    EXPECT_EQ(stage.send({0.9, 0.0, 0.0}).x, 0.9);
}

// HZ-FORCE-01
TEST(Output, GainIsAppliedBeforeTheDeviceClamp) {
    const DeviceProfile touch{.name = "touch", .force_peak_n = 3.3, .stiffness_n_per_m = 400.0, .source = ""};
    Stage soft(plain(), touch, 0.1), stiff(plain(), touch, 0.5);
    soft.state.model_n = stiff.state.model_n = {0.0, 20.0, 0.0};
    EXPECT_NEAR(soft.send({0.0, 20.0, 0.0}).y, 2.0, 1e-12);
    EXPECT_NEAR(stiff.send({0.0, 20.0, 0.0}).y, 3.3, 1e-12);
    EXPECT_TRUE(stiff.state.limited);
    Stage strong(plain(), {"strong", 100.0, 1e4, ""});
    strong.state.model_n = {0.0, 30.0, 0.0};  // above the model's own maximum force
    EXPECT_NEAR(strong.send({0.0, 30.0, 0.0}).y, 22.0, 1e-12);
}

// HZ-FORCE-03
TEST(Output, NonFiniteForceFadesFromTheLastValidForce) {
    for (const double bad : {kNaN, HUGE_VAL, -HUGE_VAL}) {
        for (const int field : {0, 1, 2}) {
            Stage stage;
            stage.state.model_n = {5.0, 0.0, 0.0};
            EXPECT_EQ(stage.send({5.0, 0.0, 0.0}).x, 5.0);
            if (field == 1) stage.tick.tool.tissue_moved_m.y = bad;
            if (field == 2) stage.tick.tool.energy_j = bad;
            const Vec3 force{field == 0 ? bad : 5.0, 0.0, 0.0};
            double last = 5.0;
            for (int i = 0; i < 15; ++i) {
                const double sent = stage.send(force).x;
                EXPECT_NEAR(sent, 5.0 * (14 - i) / 15.0, 1e-9);
                EXPECT_LE(sent, last);
                last = sent;
            }
            EXPECT_EQ(stage.state.safety.faults, kFaultBadForce);
            stage.tick.tool = {};
            for (int i = 0; i < 3000; ++i)
                EXPECT_EQ(stage.send({5.0, 0.0, 0.0}), Vec3(0.0));  // until re-armed
        }
    }
}

// The hand pushes on while the force fades. Without the fault the force would rise by 5 N.
TEST(Output, AFaultNeverRaisesTheForceEvenIfTheModelRises) {
    Stage stage;
    stage.hold({-1.0, 0.0, 0.0}, 100);
    stage.tick.fault_bits = kFaultHandOff;
    for (int i = 1; i <= 15; ++i) {
        const Vec3 sent_n = stage.send({-1.0 - i / 3.0, 0.0, 0.0});
        EXPECT_LE(glm::length(sent_n), 1.0 - i / 15.0 + 1e-9) << i;
        EXPECT_LE(sent_n.x, 0.0);
    }
}

// The passivity controller corrects the energy error of a spring that is sampled once per tick. If the tip
// moves by dx per tick, it adds the force K dx / 2 (times kMargin). The gain scales the spring's force but
// not the motion of needle and hand. K must therefore be the stiffness as sent to the device: gain * k, not
// k.
TEST(Output, ControllerLeadsTheScaledSpringByHalfATick) {
    Stage stage(plain(), {}, 0.5);
    const double k = 1000.0, dx = 20e-6;
    for (int i = 1; i <= 100; ++i) {
        stage.tick.grip_m.x = i * dx;
        stage.tick.tool.energy_j = 0.5 * k * i * i * dx * dx;
        const double sent = stage.send({-k * i * dx, 0.0, 0.0}).x;
        if (i < 20) continue;  // skip the start from rest
        EXPECT_NEAR(stage.state.controller_n.x, -kMargin * 0.5 * 0.5 * k * dx, 1e-9);
        EXPECT_NEAR(sent, -0.5 * k * (i * dx + kMargin * 0.5 * dx), 1e-9);
    }
    OutputSettings watching = plain();
    watching.controller_share = 0.0;
    Stage off(watching);
    off.tick.grip_m.x = dx;
    off.tick.tool.energy_j = 0.5 * k * dx * dx;
    EXPECT_EQ(off.send({-k * dx, 0.0, 0.0}).x, -k * dx);
    EXPECT_GT(off.state.passivity.excess_energy_j, 0.0);
}

// Returns an output stage with an energy excess of 1 J, which the passivity controller must dissipate. The
// excess is so large that only the controller's own limits determine its force.
Stage owing(double tangent_n_per_m) {
    OutputSettings settings = plain();
    settings.model_tangent_n_per_m = tangent_n_per_m;
    Stage stage(settings);
    stage.state.passivity.excess_energy_j = 1.0;
    stage.state.passivity.still = {};
    return stage;
}

TEST(Output, ControllerSlopeIsBoundedByTheBareMass) {
    Stage steep = owing(1e6);
    steep.tick.grip_m.y = 1e-6;
    // The controller's stiffness is limited to m / (4 T^2). T is the tick. m is the mass of the lightest
    // known device, because this device's mass is unknown.
    EXPECT_NEAR(steep.send(Vec3(0.0)).y, -0.25 * kLightestMass_kg / (kDt_s * kDt_s) * 1e-6, 1e-12);
}

TEST(Output, ControllerSlopeIsBoundedByTheStiffestSpring) {
    Stage soft = owing(1000.0);
    soft.tick.grip_m.y = 1e-6;
    EXPECT_NEAR(soft.send(Vec3(0.0)).y, -1000.0 * 1e-6, 1e-12);  // slope without delay: 2 K (1/2 + 0)
    Stage late = owing(1000.0);
    // The delay of 1.2 ticks is rounded up to 2. The slope is then limited by the mass of the bare mechanism,
    // m / (4 T^2 (1 + 2)), which is below the spring's limit of 2 K (1/2 + 2).
    late.profile.delay_s = 1.2 * kDt_s;
    late.tick.grip_m.y = 1e-6;
    EXPECT_NEAR(late.send(Vec3(0.0)).y, -0.25 * kLightestMass_kg / (3.0 * kDt_s * kDt_s) * 1e-6, 1e-12);
}

// HZ-FORCE-09
TEST(Output, ControllerForceChangesGradually) {
    Stage stage = owing(1e6);
    double last = 0.0;
    for (int i = 1; i <= 100; ++i) {
        stage.tick.grip_m.y = i % 10 < 5 ? 0.001 : -0.001;
        const double sent = stage.send(Vec3(0.0)).y;
        EXPECT_LE(std::fabs(sent - last), 0.1 + 1e-12);
        last = sent;
    }
}

// HZ-FORCE-19
TEST(Output, TheWallPushesBackIntoTheWorkspace) {
    DeviceProfile small;
    small.workspace_radius_m = 0.04;
    Stage stage(plain(), small);
    for (double x = 0.0; x <= 0.0401; x += 0.0002) {
        stage.tick.grip_m.x = x;
        stage.send(Vec3(0.0));
    }
    stage.hold(Vec3(0.0), 100);
    EXPECT_NEAR(stage.state.sent_n.x, -200.0 * 0.004, 0.01);
}

// Pressing the clutch scales the tissue force to zero. The force of the workspace wall remains. The passivity
// controller must not count the removed tissue force as an energy excess.
TEST(Output, ClutchRemovesOnlyTheModelForce) {
    DeviceProfile profile;
    profile.workspace_radius_m = 0.1;
    Stage stage(plain(), profile);
    stage.tick.grip_m = {0.091, 0.0, 0.0};
    stage.hold({0.0, 2.0, 0.0}, 500);
    EXPECT_NEAR(stage.state.sent_n.x, -0.2, 0.01);
    EXPECT_NEAR(stage.state.sent_n.y, 2.0, 0.01);
    stage.tick.share = 0.5;
    EXPECT_NEAR(stage.send({0.0, 2.0, 0.0}).y, 1.0, 0.01);
    stage.tick.share = 0.0;
    for (int i = 0; i < 500; ++i) {
        // While the clutch is pressed, the grip moves along the wall and the tip does not move.
        stage.tick.grip_m.y = 1e-5 * i;
        EXPECT_LT(std::fabs(stage.send({0.0, 2.0, 0.0}).y), 0.02) << i;
    }
    EXPECT_EQ(stage.state.controller_n.y, 0.0);
    EXPECT_EQ(stage.state.passivity.excess_energy_j, 0.0);
    EXPECT_LT(stage.state.sent_n.x, -0.1);
}

// The tool is in contact before the force has started, and the clutch is pressed. The clutch removes the
// contact force, but the output stage must still see it and keep waiting. Otherwise the full force would
// appear when the clutch is released.
// HZ-FORCE-02
TEST(Output, PressedClutchDoesNotHideContactAtTheStart) {
    OutputState state;
    OutputTick tick;
    tick.tool.force_n = {0.0, 2.0, 0.0};
    tick.share = 0.0;
    for (int i = 0; i < 500; ++i)
        stepOutput(state, plain(), {}, 1.0, tick, kDt_s);
    EXPECT_EQ(state.safety.stage, ForceStage::waiting);
    EXPECT_EQ(state.safety.awaited, std::uint32_t(kWaitsForSmallForce));
    tick.share = 1.0;
    EXPECT_EQ(stepOutput(state, plain(), {}, 1.0, tick, kDt_s), Vec3(0.0));
}

// A mouse cannot lose a force: whatever happens, there is nothing to re-arm and nothing to wait for, except a
// needle that it left behind.
TEST(Output, InputOnlyDeviceHasNoForceToLose) {
    const DeviceProfile mouse = inputOnlyProfile("mouse", "input only");
    for (const FaultText& fault : faultTexts()) {
        OutputState state;
        state.safety.has_pose = true;
        OutputTick tick;
        for (int i = 0; i < 3000; ++i) {
            tick.tool.force_n = {i < 2000 ? 0.0 : -5.0, 0.0, 0.0};
            tick.fault_bits = i >= 2500 && i < 2600 ? fault.bit : 0u;
            EXPECT_EQ(stepOutput(state, plain(), mouse, 0.0, tick, kDt_s), Vec3(0.0));
            ASSERT_EQ(state.safety.stage, ForceStage::waiting) << fault.name;
            const bool left_behind = fault.bit == kFaultAwayFromNeedle && tick.fault_bits != 0;
            ASSERT_EQ(state.safety.awaited, left_behind ? kFaultAwayFromNeedle : 0u) << fault.name;
        }
        EXPECT_EQ(state.safety.faults, fault.bit & kFaultBadForce) << fault.name;
    }
}

// Nobody could re-arm: a controller that is tracked again is lost no longer. One that has not been there yet
// is not lost.
TEST(Output, LossOfAnInputOnlyDeviceEndsWithItsReturn) {
    const DeviceProfile controller = inputOnlyProfile("controller", "input only");
    OutputState state;
    OutputTick tick;
    tick.fault_bits = kFaultDeviceLost;
    (void)stepOutput(state, plain(), controller, 0.0, tick, kDt_s);
    EXPECT_EQ(state.safety.faults, 0u);
    state.safety.has_pose = true;
    (void)stepOutput(state, plain(), controller, 0.0, tick, kDt_s);
    EXPECT_EQ(state.safety.faults, std::uint32_t(kFaultDeviceLost));
    tick.fault_bits = 0;
    (void)stepOutput(state, plain(), controller, 0.0, tick, kDt_s);
    EXPECT_EQ(state.safety.faults, 0u);
}

}  // namespace
}  // namespace stylet::haptics
