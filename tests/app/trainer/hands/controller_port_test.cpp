// Tests a controller as the input device without a runtime: requests, loss and recovery of tracking, and
// vibration.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>
#include <string>

#include "app/trainer/hands/controller_hand.h"
#include "tests/support/stepped_clock.h"

namespace stylet::trainer {
namespace {

using haptics::DeviceStage;
using haptics::DeviceState;
using haptics::Phase;
using haptics::TickOutput;
using haptics::Tool;
using patient::Tissue;

Pose heldTurned(double x_m) {
    return {glm::angleAxis(0.5, Vec3(0.0, 1.0, 0.0)), Vec3(x_m, 1.0, -0.4)};
}

TEST(ControllerPort, NeedleFollowsTheControllersAim) {
    ControllerPort port;
    std::uint32_t buttons = 0;
    EXPECT_FALSE(port.toolAt(0, buttons));
    std::int64_t asked_ns = 0;
    port.attach([&](std::int64_t when_ns) {
        asked_ns = when_ns;
        return std::optional(heldTurned(0.1));
    });
    const Pose room{glm::angleAxis(1.0, Vec3(0.0, 1.0, 0.0)), Vec3(0.5, 0.2, 0.0)};
    const Pose grip_from_aim{glm::angleAxis(-0.7, Vec3(1.0, 0.0, 0.0)), Vec3(0.0, 0.01, -0.02)};
    port.publish({room, grip_from_aim, controllerButtons({true, false, 0.9f})});
    const auto tool = port.toolAt(77, buttons);
    ASSERT_TRUE(tool);
    EXPECT_EQ(asked_ns, 77);
    EXPECT_EQ(buttons, 0b101u);
    const Pose aim = room * heldTurned(0.1) * grip_from_aim;
    // The tip is in front of the controller, and the hub points to the hand.
    EXPECT_NEAR(glm::length(tool->position_m - aim * Vec3(0.0, 0.0, -0.15)), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(tool->direction({0.0, 0.0, 1.0}) - aim.direction({0.0, 0.0, 1.0})), 0.0, 1e-12);
    // A frame without an aim pose keeps the previous one.
    port.publish({room, std::nullopt, 0});
    EXPECT_NEAR(glm::length(port.toolAt(78, buttons)->position_m - tool->position_m), 0.0, 1e-12);
    EXPECT_EQ(buttons, 0u);
}

TEST(ControllerDriver, IsLostWithTheSessionAndComesBackWithIt) {
    test::SteppedClock time;
    ControllerPort port;
    ControllerDriver driver(port, ControllerSide::left, time.clock());
    std::string why;
    EXPECT_EQ(driver.open(why), DeviceStage::absent);
    EXPECT_THAT(why, testing::HasSubstr("left hand"));
    double x_m = 0.0;
    bool tracked = true;
    const auto grip = [&](std::int64_t) { return tracked ? std::optional(heldTurned(x_m)) : std::nullopt; };
    port.attach(grip);
    EXPECT_EQ(driver.open(why), DeviceStage::ready);
    DeviceState state;
    state.fresh = 0;
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::ready);
    EXPECT_EQ(state.fresh, 1u);
    const Vec3 before_m = state.device_from_stylus.position_m;

    // A short loss of tracking: the device reports the last pose, marked as not fresh.
    tracked = false;
    state.fresh = 0;
    for (int i = 0; i < 100; ++i) {
        time.now_ns += ControllerDriver::kLostAfter_ns / 100;
        EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::ready);
    }
    EXPECT_EQ(state.fresh, 0u);
    EXPECT_EQ(state.device_from_stylus.position_m, before_m);
    time.now_ns += 1;
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::absent);
    EXPECT_EQ(driver.open(why), DeviceStage::absent);

    tracked = true;
    x_m = 0.3;
    EXPECT_EQ(driver.open(why), DeviceStage::ready);
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::ready);
    EXPECT_NEAR(state.device_from_stylus.position_m.x - before_m.x, 0.3, 1e-12);
    port.attach(nullptr);
    EXPECT_EQ(driver.open(why), DeviceStage::absent);
}

// The device's thread stands still for half a second, and one look afterwards finds no controller. It may
// have been tracked all the time.
TEST(ControllerDriver, AStallOfTheComputerIsNoLossOfTracking) {
    test::SteppedClock time;
    ControllerPort port;
    ControllerDriver driver(port, ControllerSide::right, time.clock());
    bool tracked = true;
    port.attach([&](std::int64_t) { return tracked ? std::optional(heldTurned(0.0)) : std::nullopt; });
    std::string why;
    ASSERT_EQ(driver.open(why), DeviceStage::ready);
    DeviceState state;
    tracked = false;
    time.now_ns += 500'000'000;
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::ready);
    tracked = true;
    state.fresh = 0;
    time.now_ns += 500'000'000;
    EXPECT_EQ(driver.exchange({}, state, why), DeviceStage::ready);
    EXPECT_EQ(state.fresh, 1u);
    tracked = false;
    int ms = 0;
    for (; driver.exchange({}, state, why) == DeviceStage::ready && ms < 1000; ++ms)
        time.now_ns += 1'000'000;
    EXPECT_EQ(ms, 101);
}

TickOutput needleAt(Phase phase, Tissue tissue, double depth_m) {
    TickOutput tick;
    tick.phase = phase;
    tick.tissue = tissue;
    tick.depth_m = depth_m;
    return tick;
}

TEST(Vibrations, PulseOnceForTouchAndEveryCut) {
    Vibrations vibrations;
    const auto strength = [&](const TickOutput& tick) {
        const auto v = vibrations.update(tick);
        return v ? v->amplitude : 0.0f;
    };
    EXPECT_EQ(strength(needleAt(Phase::outside, Tissue::air, 0.0)), 0.0f);
    const float touch = strength(needleAt(Phase::tenting, Tissue::air, 0.001));
    EXPECT_GT(touch, 0.0f);
    EXPECT_EQ(strength(needleAt(Phase::tenting, Tissue::air, 0.002)), 0.0f);
    const float cut = strength(needleAt(Phase::pass, Tissue::skin, 0.003));
    EXPECT_GT(cut, touch);
    EXPECT_EQ(strength(needleAt(Phase::pass, Tissue::skin, 0.004)), 0.0f);
    EXPECT_EQ(strength(needleAt(Phase::pass, Tissue::soft, 0.005)), cut);
    EXPECT_EQ(strength(needleAt(Phase::tenting, Tissue::soft, 0.006)), 0.0f);
    EXPECT_EQ(strength(needleAt(Phase::pass, Tissue::fascia, 0.007)), cut);
    // No vibration for a border that is passed while the needle is withdrawn.
    EXPECT_EQ(strength(needleAt(Phase::pass, Tissue::soft, 0.005)), 0.0f);
    EXPECT_EQ(strength(needleAt(Phase::outside, Tissue::air, 0.0)), 0.0f);
    // A change of tool does not vibrate, but the new tool's first contact does.
    TickOutput finger;
    finger.tool = Tool::finger;
    EXPECT_EQ(strength(finger), 0.0f);
    finger.tool_force.force_n = {0.3, 0.0, 0.0};
    EXPECT_EQ(strength(finger), touch);
    EXPECT_EQ(strength(finger), 0.0f);
}

}  // namespace
}  // namespace stylet::trainer
