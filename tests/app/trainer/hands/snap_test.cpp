// Snap to skin: where a tool is placed, how it moves there, and when it is refused.
#include "app/trainer/hands/snap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/constants.h"
#include "tests/support/stepped_clock.h"

namespace stylet::trainer {
namespace {

using haptics::TickOutput;
using haptics::Tool;
using training::Difficulty;

const Vec3 kIn{1.0, 0.0, 0.0};  // into the phantom, whose skin is flat at x = 0

class Snap : public testing::Test {
  protected:
    static Pose held(const Vec3& tip_m, const Vec3& inward) {
        return needlePose(tip_m, glm::normalize(inward));
    }
    static TickOutput with(Tool tool, const Pose& patient_from_tool) {
        TickOutput now;
        now.tool = tool;
        now.patient_from_tool = now.patient_from_needle = patient_from_tool;
        return now;
    }
    std::optional<Pose> snap(const TickOutput& now, Difficulty difficulty = Difficulty::practice) {
        return poseOnSkin(test::difficulties()[difficulty], now, patient_, touch_, why_not_);
    }
    // Expects a refusal with this reason.
    void expectRefused(const TickOutput& now, const std::string& reason,
                       Difficulty difficulty = Difficulty::guided) {
        EXPECT_FALSE(snap(now, difficulty));
        EXPECT_NE(why_not_.find(reason), std::string::npos) << why_not_;
    }

    const patient::Package package_ = test::ductPhantom();
    const patient::Patient patient_{package_};
    const haptics::TouchMap touch_ = haptics::makeTouchMap(patient_);
    std::string why_not_;
};

TEST_F(Snap, ToolsThatPressStandOnTheSkinTheyPointAt) {
    const Vec3 lean = glm::normalize(Vec3(1.0, 0.2, -0.3));
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel}) {
        const Pose start = held({-0.014, 0.002, 0.003}, lean);
        const Vec3 inward = start.direction({0.0, 0.0, -1.0});
        const std::optional<Pose> pose = snap(with(tool, start));
        ASSERT_TRUE(pose) << why_not_;
        EXPECT_EQ(why_not_, "");
        const double above_m = tool == Tool::scalpel ? 0.003 : tool == Tool::probe ? -0.001 : 0.0;
        const Vec3 met_m = start.position_m - inward * (start.position_m.x / inward.x);
        EXPECT_LT(glm::distance(pose->position_m, met_m - above_m * kIn), 0.0012) << int(tool);
        EXPECT_NEAR(glm::dot(pose->direction({0.0, 0.0, -1.0}), kIn), 1.0, 1e-3) << int(tool);
        // The smallest rotation does that: the tool is not rolled.
        const Quat turn = pose->rotation * glm::conjugate(start.rotation);
        EXPECT_NEAR(2.0 * std::acos(std::min(1.0, std::fabs(turn.w))),
                    std::acos(glm::dot(inward, pose->direction({0.0, 0.0, -1.0}))), 1e-6);
    }
}

TEST_F(Snap, NeedleKeepsTheDirectionThatTheTraineeHasChosen) {
    const Pose start = held({-0.015, 0.0, 0.0}, {1.0, 0.3, 0.0});
    const std::optional<Pose> pose = snap(with(Tool::needle, start));
    ASSERT_TRUE(pose) << why_not_;
    EXPECT_EQ(pose->rotation, start.rotation);
    EXPECT_NEAR(pose->position_m.x, -0.003, 0.001);
    EXPECT_LT(pose->position_m.x, 0.0) << "in front of the skin";
}

TEST_F(Snap, IsRefusedWithAReason) {
    const TickOutput above = with(Tool::finger, held({-0.015, 0.0, 0.0}, kIn));
    EXPECT_TRUE(snap(above, Difficulty::guided));
    EXPECT_TRUE(snap(above, Difficulty::practice));
    for (int tool = 0; tool < haptics::kToolCount; ++tool) {
        TickOutput now = above;
        now.tool = Tool(tool);
        expectRefused(now, "this difficulty", Difficulty::exam);
    }
    for (const haptics::Phase phase : {haptics::Phase::tenting, haptics::Phase::pass}) {
        TickOutput inside = with(Tool::needle, held({0.0005, 0.0, 0.0}, kIn));
        inside.phase = phase;
        expectRefused(inside, "the needle is in the body");
        inside.tool = Tool::guide;
        expectRefused(inside, "the needle is in the body");
    }
    TickOutput cutting = with(Tool::scalpel, held({0.001, 0.0, 0.0}, kIn));
    cutting.cut_incision = 0;
    expectRefused(cutting, "the scalpel is in the skin");
    for (const Tool tool : {Tool::wire, Tool::dilator, Tool::drain})
        expectRefused(with(tool, above.patient_from_tool), "track");
    // Taken inside the body: there is no way out that is known to be free.
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel, Tool::needle})
        expectRefused(with(tool, held({0.030, 0.0, 0.0}, kIn)), "the tool is in the body");
    expectRefused(with(Tool::finger, held({-0.50, 0.0, 0.0}, kIn)), "no skin");
    expectRefused(with(Tool::finger, held({-0.05, 0.0, 0.0}, -kIn)), "no skin");
}

TEST_F(Snap, TouchingIsNoticed) {
    TickOutput now = with(Tool::finger, held({-0.015, 0.0, 0.0}, kIn));
    EXPECT_FALSE(touchesPatient(now));
    TickOutput pressing = now, scanning = now, inside = now, cutting = now;
    pressing.tool_force.force_n = {-0.1, 0.0, 0.0};
    scanning.probe_touching_share = 0.1;
    inside.phase = haptics::Phase::tenting;
    cutting.cut_incision = 0;
    for (const TickOutput& touching : {pressing, scanning, inside, cutting})
        EXPECT_TRUE(touchesPatient(touching));
}

// A whole snap of each tool with the mouse, through driver and simulation, from several places: the tool
// arrives, never faster than a hand, and nothing is punctured or cut on the way.
TEST_F(Snap, MousesToolArrivesWithoutEnteringTheBody) {
    for (const Tool tool : {Tool::finger, Tool::probe, Tool::scalpel, Tool::needle})
        for (const Vec3& from : {Vec3(-0.018, 0.0, 0.0), Vec3(-0.010, 0.008, -0.008)}) {
            const Scenario scenario = test::shortScenario();
            Attempt attempt = makeAttempt(patient_, scenario, test::ductPath(), 1);
            attempt.simulation.patient_from_device = {};
            attempt.simulation.profile = mouseProfile();
            attempt.simulation.tools.first = tool;
            haptics::Simulation simulation(patient_, attempt.simulation, &touch_);
            test::SteppedClock time;
            WindowPort port;
            port.publish(tool, 0.0);
            const haptics::GuideSettings& guide = attempt.simulation.tools.guide;
            const Pose needle = held(from, {1.0, 0.3, 0.2}) * toolPoseFromNeedle({}, tool, guide).inverse();
            MouseDriver driver(port, needle, guide, time.clock());
            std::string why;
            driver.open(why);
            TickOutput now;
            std::optional<Pose> goal;
            double fastest_m_s = 0.0, hardest_n = 0.0;
            Vec3 last_m{0.0};
            for (int tick = 0; tick < 3000; ++tick) {
                time.now_ns += 1'000'000;
                haptics::TickInput input;
                ASSERT_EQ(driver.exchange(Vec3(0.0), input.device, why), haptics::DeviceStage::ready);
                haptics::NeedleEvents events;
                simulation.step(input, now, events);
                EXPECT_EQ(events.count, 0) << "the needle cut something";
                EXPECT_EQ(now.incision_count, 0);
                EXPECT_EQ(now.phase, haptics::Phase::outside);
                hardest_n = std::max(hardest_n, glm::length(now.tool_force.force_n));
                if (tick > 0)
                    fastest_m_s = std::max(
                        fastest_m_s, glm::distance(now.patient_from_tool.position_m, last_m) / test::kDt_s);
                last_m = now.patient_from_tool.position_m;
                if (tick != 100) continue;
                goal = snap(now);
                ASSERT_TRUE(goal) << why_not_;
                ASSERT_TRUE(port.snapTo(*goal));
            }
            EXPECT_LT(glm::distance(now.patient_from_tool.position_m, goal->position_m), 1e-4) << int(tool);
            EXPECT_NEAR(std::fabs(glm::dot(now.patient_from_tool.rotation, goal->rotation)), 1.0, 1e-6);
            EXPECT_LT(hardest_n, MouseDriver::kMaxPress_n) << int(tool);
            EXPECT_LT(fastest_m_s, 0.25);
            EXPECT_GT(fastest_m_s, 0.0);
            EXPECT_EQ(now.faults & (haptics::kFaultOverSpeed | haptics::kFaultAwayFromNeedle), 0u);
        }
}

// The same requests give the same poses, so a record of them replays to the same hash.
TEST_F(Snap, IsDeterministic) {
    const auto hash = [&] {
        Attempt attempt = makeAttempt(patient_, test::shortScenario(), test::ductPath(), 1);
        attempt.simulation.patient_from_device = {};
        attempt.simulation.tools.first = Tool::finger;
        haptics::Simulation simulation(patient_, attempt.simulation, &touch_);
        test::SteppedClock time;
        WindowPort port;
        port.publish(Tool::finger, 0.0);
        MouseDriver driver(port, needlePose({-0.018, 0.0, 0.0}, kIn), {}, time.clock());
        std::string why;
        driver.open(why);
        TickOutput now;
        for (int tick = 0; tick < 1500; ++tick) {
            time.now_ns += 1'000'000;
            haptics::TickInput input;
            driver.exchange(Vec3(0.0), input.device, why);
            haptics::NeedleEvents events;
            simulation.step(input, now, events);
            if (tick == 200) {
                EXPECT_TRUE(port.snapTo(snap(now).value()));
            }
            if (tick == 900) port.move({.deeper_m = 0.004});
        }
        return now.state_hash;
    };
    EXPECT_EQ(hash(), hash());
}

// If the mouse's thread hangs, requests are refused, and the user reads why.
TEST(RequestSnap, SaysThatTheRingIsFull) {
    WindowPort mouse;
    std::string why_not;
    int accepted = 0;
    while (accepted < 100 && (why_not = requestSnap({}, nullptr, mouse)).empty())
        ++accepted;
    EXPECT_GT(accepted, 0);
    EXPECT_LT(accepted, 100);
    EXPECT_NE(why_not.find("still waiting"), std::string::npos) << why_not;
    Pose popped;
    ASSERT_TRUE(mouse.popSnap(popped));
    EXPECT_EQ(requestSnap({}, nullptr, mouse), "");
    // Of a controller's requests the newest counts.
    ControllerPort controller;
    for (int i = 0; i < 100; ++i)
        EXPECT_EQ(requestSnap({{1.0, 0.0, 0.0, 0.0}, {0.01 * i, 0.0, 0.0}}, &controller, mouse), "");
    const std::optional<Pose> newest = controller.popSnap();
    ASSERT_TRUE(newest);
    EXPECT_DOUBLE_EQ(newest->position_m.x, 0.99);
}

// A hand with a controller, 10 cm from the skin.
class ControllerSnap : public testing::Test {
  protected:
    void SetUp() override {
        port_.attach([this](std::int64_t) { return std::optional(hand_); });
        EXPECT_EQ(driver_.open(why_), haptics::DeviceStage::ready);
    }
    Pose after(int exchanges, bool trigger) {
        port_.publish({{}, Pose{}, trigger ? kSnapButton : 0u});
        haptics::DeviceState state;
        for (int i = 0; i < exchanges; ++i) {
            time_.now_ns += 4'000'000;
            EXPECT_EQ(driver_.exchange(Vec3(0.0), state, why_), haptics::DeviceStage::ready);
            const Vec3 at_m = state.device_from_stylus.position_m;
            if (moved_) fastest_m_s_ = std::max(fastest_m_s_, glm::distance(at_m, last_m_) / 0.004);
            moved_ = true, last_m_ = at_m;
        }
        return state.device_from_stylus;
    }
    test::SteppedClock time_;
    Pose hand_{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.10, 0.0}};
    ControllerPort port_;
    ControllerDriver driver_{port_, ControllerSide::right, time_.clock()};
    std::string why_;
    Vec3 last_m_{0.0};
    bool moved_ = false;
    double fastest_m_s_ = 0.0;
};

TEST_F(ControllerSnap, HoldsTheToolOnTheSkinWhileTheTriggerIsHeld) {
    const Pose free = after(10, false);
    const Pose goal{glm::angleAxis(0.5, Vec3(1.0, 0.0, 0.0)), free.position_m + Vec3(0.0, -0.10, 0.02)};
    port_.snapTo(goal);
    const Pose snapped = after(500, true);
    EXPECT_LT(glm::distance(snapped.position_m, goal.position_m), 1e-9);
    EXPECT_NEAR(std::fabs(glm::dot(snapped.rotation, goal.rotation)), 1.0, 1e-9);
    EXPECT_LE(fastest_m_s_, SnapOffset::kSpeed_m_s * 1.001);
    EXPECT_GT(fastest_m_s_, 0.0);
    // The tool follows the hand from there.
    hand_.position_m += Vec3(0.01, 0.0, 0.0);
    EXPECT_LT(glm::distance(after(1, true).position_m, goal.position_m + Vec3(0.01, 0.0, 0.0)), 1e-9);
    hand_.position_m -= Vec3(0.01, 0.0, 0.0);
    after(1, true);
    // Released, but touching: a tool on or in the patient is not moved by that.
    port_.setTouching(true);
    EXPECT_LT(glm::distance(after(500, false).position_m, goal.position_m), 1e-9);
    port_.setTouching(false);
    fastest_m_s_ = 0.0;
    const Pose back = after(500, false);
    EXPECT_LT(glm::distance(back.position_m, free.position_m), 1e-9);
    EXPECT_NEAR(std::fabs(glm::dot(back.rotation, free.rotation)), 1.0, 1e-9);
    EXPECT_LE(fastest_m_s_, SnapOffset::kSpeed_m_s * 1.001);
}

// Without the session's consent, the trigger does nothing.
TEST_F(ControllerSnap, TriggerAloneMovesNothing) {
    const Pose free = after(10, false);
    EXPECT_EQ(after(500, true).position_m, free.position_m);
    EXPECT_EQ(after(1, true).rotation, free.rotation);
}

}  // namespace
}  // namespace stylet::trainer
