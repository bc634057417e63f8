// Tests the mouse as the input device: smooth and limited motion. Also tests that command lines from the
// window arrive complete.
#include "app/trainer/hands/mouse_hand.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <gtest/gtest.h>

#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/stepped_clock.h"

namespace stylet::trainer {
namespace {

using haptics::DeviceState;

const Pose kStart{{1.0, 0.0, 0.0, 0.0}, {0.10, 0.02, -0.03}};

class MouseHand : public testing::Test {
  protected:
    void SetUp() override { EXPECT_EQ(driver_.open(why_), haptics::DeviceStage::ready); }
    Pose after(int ticks, std::int64_t tick_ns = 1'000'000) {
        DeviceState state;
        for (int i = 0; i < ticks; ++i) {
            time_.now_ns += tick_ns;
            EXPECT_EQ(driver_.exchange(Vec3(0.0), state, why_), haptics::DeviceStage::ready);
            EXPECT_EQ(state.fresh, 1u);
            const Vec3 at = state.device_from_stylus.position_m;
            if (ticks_++ > 0) {
                const Vec3 velocity = (at - at_) / (double(tick_ns) * 1e-9);
                fastest_ = std::max(fastest_, glm::length(velocity));
                hardest_ = std::max(hardest_, glm::length(velocity - velocity_) / (double(tick_ns) * 1e-9));
                velocity_ = velocity;
            }
            at_ = at;
        }
        return state.device_from_stylus;
    }
    test::SteppedClock time_;
    WindowPort port_;
    MouseDriver driver_{port_, kStart, {}, time_.clock()};
    std::string why_;
    int ticks_ = 0;
    Vec3 at_{0.0}, velocity_{0.0};
    double fastest_ = 0.0, hardest_ = 0.0;
};

TEST_F(MouseHand, MouseStepBecomesASmoothMoveOfTheSameLength) {
    after(10);
    port_.move({.moved_m = {0.0, 0.05, 0.0}});
    const Pose there = after(2000);
    EXPECT_NEAR(glm::length(there.position_m - kStart.position_m - Vec3(0.0, 0.05, 0.0)), 0.0, 1e-6);
    EXPECT_LE(fastest_, SmoothPoint::kSpeed_m_s * 1.001);
    EXPECT_GT(fastest_, 0.9 * SmoothPoint::kSpeed_m_s);
    // From rest, the spring's largest acceleration is 2 * speed * rate.
    EXPECT_LE(hardest_, 2.001 * SmoothPoint::kSpeed_m_s * SmoothPoint::kRate_per_s);
}

TEST_F(MouseHand, RespondsAsACriticallyDampedSpring) {
    after(1);
    port_.move({.moved_m = {0.004, 0.0, 0.0}});
    // The next tick applies the move: x(t) = 1 - (1 + wt) exp(-wt).
    for (const int ms : {20, 50, 100}) {
        const double at = after(ms - (ticks_ - 1)).position_m.x - kStart.position_m.x;
        const double wt = SmoothPoint::kRate_per_s * ms * 1e-3;
        EXPECT_NEAR(at, 0.004 * (1.0 - (1.0 + wt) * std::exp(-wt)), 0.02 * 0.004) << ms;
    }
}

TEST_F(MouseHand, DeeperMovesAlongTheTool) {
    after(1);
    port_.move({.turned_rad = {0.0, 0.5, 0.0}});
    const Pose turned = after(3000);
    EXPECT_NEAR(glm::length(turned.position_m - kStart.position_m), 0.0, 1e-9);
    EXPECT_NEAR(glm::dot(turned.direction({0, 0, 1}), Vec3(0, 0, 1)), std::cos(0.5), 1e-6);
    port_.move({.deeper_m = 0.02});
    const Pose deeper = after(3000);
    EXPECT_NEAR(glm::length(deeper.position_m - turned * Vec3(0, 0, -0.02)), 0.0, 1e-6);
    port_.move({.home = true});
    const Pose home = after(4000);
    EXPECT_NEAR(glm::length(home.position_m - kStart.position_m), 0.0, 1e-6);
    EXPECT_NEAR(std::fabs(glm::dot(home.rotation, kStart.rotation)), 1.0, 1e-6);
}

// Rolling does not change the tool's direction.
TEST_F(MouseHand, RollTurnsAboutTheShaft) {
    after(1);
    port_.move({.turned_rad = {0.4, -0.3, 0.0}});
    const Pose turned = after(3000);
    port_.move({.rolled_rad = 0.6});
    const Pose rolled = after(3000);
    EXPECT_NEAR(glm::length(rolled.position_m - turned.position_m), 0.0, 1e-9);
    EXPECT_NEAR(glm::length(rolled.direction({0, 0, 1}) - turned.direction({0, 0, 1})), 0.0, 1e-6);
    const Vec3 x = turned.inverse().direction(rolled.direction({1, 0, 0}));
    EXPECT_NEAR(glm::length(x - Vec3(std::cos(0.6), std::sin(0.6), 0.0)), 0.0, 1e-6);
}

TEST_F(MouseHand, PressLimitStopsAdvanceButNotWithdrawal) {
    after(1);
    port_.publish(haptics::Tool::finger, MouseDriver::kMaxPress_n + 1.0);
    port_.move({.deeper_m = 0.03});
    EXPECT_NEAR(glm::length(after(1000).position_m - kStart.position_m), 0.0, 1e-9);
    port_.move({.deeper_m = -0.01});
    EXPECT_NEAR(after(2000).position_m.z - kStart.position_m.z, 0.01, 1e-6);
}

// A thread that was not scheduled for a second must not cause a jump.
TEST_F(MouseHand, DelayedRotationDoesNotJump) {
    after(5);
    port_.move({.moved_m = {0.05, 0.0, 0.0}});
    const Vec3 before = at_;
    EXPECT_LE(glm::length(after(1, 1'000'000'000).position_m - before), 0.02 * SmoothPoint::kSpeed_m_s);
}

TEST(WindowPortTest, LinesArriveWholeAndInOrderAndTooManyAreRefused) {
    WindowPort port;
    EXPECT_EQ(port.typed(), "");
    EXPECT_TRUE(port.pushLine("probe"));
    EXPECT_TRUE(port.pushLine(std::string(300, 'x')));
    EXPECT_TRUE(port.pushLine(""));
    EXPECT_EQ(port.typed(), "probe\n" + std::string(WindowPort::kMaxLineLength, 'x') + "\n\n");
    int taken = 0;
    while (port.pushLine("next"))
        ++taken;
    EXPECT_EQ(taken, 64);
}

// Where an exam begins says nothing about the path: it is in the air above the patient, elsewhere for each
// seed.
TEST(MouseStart, InTheRoomIsInTheAirAndAnywhere) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const patient::PlannedPath path = test::ductPath();
    const auto start = [&](std::uint64_t seed) {
        return mouseStart(training::StartPlace::room, patient, path, seed);
    };
    EXPECT_EQ(start(5).position_m, start(5).position_m);
    Vec3 low(1.0), high(-1.0);
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const Pose pose = start(seed);
        const Grid& grid = package.ct.grid;
        EXPECT_TRUE(!grid.contains(grid.nearest(pose.position_m)) ||
                    patient.at(pose.position_m, {true, false}).tissue == patient::Tissue::air);
        EXPECT_GT(pose.direction({0, 0, 1}).y, 0.5) << "the tool points at the patient from above";
        low = glm::min(low, pose.position_m), high = glm::max(high, pose.position_m);
    }
    const Vec3 extent_m = package.ct.grid.spacing_m * Vec3(package.ct.grid.dims);
    EXPECT_GT(high.x - low.x, 0.3 * extent_m.x);
    EXPECT_GT(high.z - low.z, 0.4 * extent_m.z);
    const Pose planned = mouseStart(training::StartPlace::path, patient, path, 5);
    EXPECT_NEAR(glm::length(planned.position_m - path.entry_m), 0.030, 1e-9);
}

}  // namespace
}  // namespace stylet::trainer
