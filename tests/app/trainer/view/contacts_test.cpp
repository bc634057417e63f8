// Contacts for drawing, computed from ticks: a dimple before the skin is punctured, its relaxation, and
// tenting while the needle is withdrawn.
#include "app/trainer/view/contacts.h"

#include <gtest/gtest.h>

#include "tests/haptics/scripted.h"
#include "tests/support/phantom.h"

namespace stylet::trainer {
namespace {

using haptics::TickOutput;

TickOutput tickWith(const Pose& patient_from_tool, haptics::Tool tool) {
    TickOutput out;
    out.tool = tool;
    out.patient_from_tool = out.patient_from_needle = patient_from_tool;
    return out;
}

TEST(Contacts, NoContactOutsideTheBody) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    EXPECT_EQ(
        findContacts(tickWith({test::kAlongX, {-0.001, 0.0, 0.0}}, haptics::Tool::needle), patient, {}).count,
        0);
}

// A whole puncture along +x. The skin begins at x = 0.
TEST(Contacts, TheSkinFollowsTheTipUntilItIsCutAndTheShaftAfterThat) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    haptics::Simulation simulation(patient, {});
    const haptics::Trace trace = test::scriptedTrace();
    double deepest_before_m = 0.0, min_begin_x_m = 0.0;
    bool cut = false;
    for (int i = 0; i < test::kScriptedTicks; ++i) {
        TickOutput out;
        haptics::NeedleEvents events;
        simulation.step(test::scriptedInput(trace, i), out, events);
        const ToolContacts contacts = findContacts(out, patient, {});
        if (contacts.count == 0) continue;
        const patient::ToolContact& c = contacts.list[0];
        const double tip_x = out.patient_from_needle.position_m.x;
        // The tissue at the tip has moved with the tip.
        EXPECT_NEAR(c.end_m.x + c.end_moved_m.x, tip_x, 1e-9);
        // The contact begins where the needle entered the skin.
        EXPECT_NEAR(c.begin_m.x, 0.0, 2e-4);
        if (out.phase == haptics::Phase::tenting && out.tissue == patient::Tissue::air) {
            EXPECT_FALSE(cut);
            EXPECT_EQ(c.begin_moved_m, c.end_moved_m);
            deepest_before_m = std::max(deepest_before_m, c.begin_moved_m.x);
        } else {
            cut = true;
            EXPECT_LE(std::fabs(c.begin_moved_m.x), 0.00095);
        }
        min_begin_x_m = std::min(min_begin_x_m, c.begin_moved_m.x);
    }
    EXPECT_TRUE(cut);
    EXPECT_NEAR(deepest_before_m, 0.000875, 2e-5);  // 0.7 N at 0.8 N/mm
    EXPECT_LT(min_begin_x_m, -0.0003);              // the skin tents while the needle is withdrawn
}

TEST(Contacts, FingerDisplacesTheSkinToItsPad) {
    const patient::Package package =
        test::makeSlabs({{patient::Tissue::skin, 0.002}, {patient::Tissue::soft, 0.028}}, 0.001);
    const patient::Patient patient(package);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    const auto pressed = [&](double x) {
        return findContacts(tickWith({test::kAlongX, {x, 0.0, 0.0}}, haptics::Tool::finger), patient,
                            {&touch});
    };
    EXPECT_EQ(pressed(-0.002).count, 0);
    const ToolContacts contacts = pressed(0.005);
    ASSERT_EQ(contacts.count, 1);
    EXPECT_NEAR(contacts.list[0].begin_m.x, 0.0, 5e-4);
    EXPECT_NEAR(contacts.list[0].begin_m.x + contacts.list[0].begin_moved_m.x, 0.005, 1e-9);
    EXPECT_EQ(
        findContacts(tickWith({test::kAlongX, {0.005, 0.0, 0.0}}, haptics::Tool::finger), patient, {}).count,
        0);
}

// The probe's face is curved, so its centre presses deeper than its ends.
TEST(Contacts, TheParkedProbePressesBesideTheNeedle) {
    const patient::Package package =
        test::makeSlabs({{patient::Tissue::skin, 0.002}, {patient::Tissue::soft, 0.028}}, 0.001);
    const patient::Patient patient(package);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    TickOutput out = tickWith({test::kAlongX, {-0.010, 0.0, 0.0}}, haptics::Tool::needle);
    out.probe_parked = true;
    out.patient_from_probe = Pose{test::kAlongX, {0.004, 0.0, 0.0}} * haptics::kStylusFromProbe;
    const ToolContacts contacts = findContacts(out, patient, {&touch});
    ASSERT_GE(contacts.count, 2);
    double middle_m = 0.0, least_m = 1.0;
    for (const patient::ToolContact& c : contacts.all()) {
        middle_m = std::max(middle_m, c.begin_moved_m.x);
        least_m = std::min(least_m, c.begin_moved_m.x);
    }
    EXPECT_NEAR(middle_m, 0.004, 5e-4);
    EXPECT_LT(least_m, 0.003);
}

TEST(Contacts, RelaxOverTicks) {
    const patient::Package package = test::scriptedPackage();
    const patient::Patient patient(package);
    ToolPress press(patient, {});
    TickOutput out = tickWith({test::kAlongX, {0.0008, 0.0, 0.0}}, haptics::Tool::needle);
    EXPECT_EQ(press.shown(out), nullptr);
    out.phase = haptics::Phase::tenting;
    out.extension_m = out.depth_m = 0.0008;
    const auto depth = [&] {
        const patient::DisplacementTable* table = press.shown(out);
        return table ? displacementAt(*table, Vec3(0.0008, 0.0, 0.0)).x : 0.0;
    };
    const double pressed_m = depth();
    EXPECT_NEAR(pressed_m, 0.0008, 5e-5);
    out.phase = haptics::Phase::outside;
    out.tick = 60;
    EXPECT_NEAR(depth() / pressed_m, 0.37, 0.06);
    out.tick = 1000;
    EXPECT_EQ(press.shown(out), nullptr);
}

}  // namespace
}  // namespace stylet::trainer
