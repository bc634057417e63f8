// Tests the driver with emulated SpaceMice, on the test's clock.
#include "haptics/devices/spacemouse/spacemouse.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"
#include "tests/support/spacemouse_emulator.h"
#include "tests/support/stepped_clock.h"

namespace stylet::haptics {
namespace {

using test::kMs;
using test::SpaceMouseEmulator;
using Age = SpaceMouseEmulator::Age;

class SpaceMouseDriver : public testing::Test {
  protected:
    void SetUp() override {
        if (!test::underUmockdev()) GTEST_SKIP() << "not run under umockdev";
    }
    DeviceStage exchange(Driver& driver, std::int64_t after_ns = kMs) {
        time_.now_ns += after_ns;
        state_.fresh = 0;
        why_.clear();
        return driver.exchange(Vec3{0.0}, state_, why_);
    }
    Vec3 start() const { return {0.0, 0.0, rate_.reach_m - 0.005}; }
    const Vec3& position() const { return state_.device_from_stylus.position_m; }

    test::SteppedClock time_;
    const Clock clock_ = time_.clock();
    const RateSettings rate_;
    DeviceState state_;
    std::string why_;
};

TEST_F(SpaceMouseDriver, IsAbsentWithoutOneAndIgnoresOrdinaryMice) {
    const test::HidNode cad_mouse({0x256f, 0xc650, "3Dconnexion", "CadMouse", {0x05, 0x01, 0x09, 0x02}});
    SpaceMouse driver(clock_);
    EXPECT_EQ(driver.open(why_), DeviceStage::absent);
    EXPECT_EQ(driver.profile().force_axes, 0);
    EXPECT_EQ(driver.profile().force_peak_n, 0.0);
}

TEST_F(SpaceMouseDriver, OldAndNewMoveTheNeedleAlike) {
    Pose poses[2];
    for (const Age age : {Age::old, Age::recent}) {
        SpaceMouseEmulator cap(age);
        SpaceMouse driver(clock_);
        ASSERT_EQ(driver.open(why_), DeviceStage::ready) << why_;
        for (int i = 0; i < 20; ++i) {
            ASSERT_TRUE(cap.push({350, 0, -350, 0, 0, 120}));
            ASSERT_EQ(exchange(driver), DeviceStage::ready);
            ASSERT_TRUE(cap.turn({350, 0, -350, 0, 0, 120}));
            for (int k = 1; k < 10; ++k)
                ASSERT_EQ(exchange(driver), DeviceStage::ready);
        }
        poses[age == Age::old ? 0 : 1] = state_.device_from_stylus;
        driver.close();
    }
    EXPECT_NEAR(poses[0].position_m.x, 0.2 * rate_.speed_m_s, 0.012 * rate_.speed_m_s) << "right";
    EXPECT_NEAR(poses[0].position_m.y, 0.2 * rate_.speed_m_s, 0.012 * rate_.speed_m_s) << "pulled up";
    EXPECT_EQ(poses[0].position_m.z, start().z);
    EXPECT_LT(poses[0].rotation.y, -1e-4) << "about the cap's downward axis";
    EXPECT_NEAR(poses[0].position_m.x, poses[1].position_m.x, 0.012 * rate_.speed_m_s);
}

TEST_F(SpaceMouseDriver, StopsWithTheCapAndReportsButtons) {
    SpaceMouseEmulator cap(Age::recent);
    SpaceMouse driver(clock_);
    ASSERT_EQ(driver.open(why_), DeviceStage::ready);
    ASSERT_TRUE(cap.push({0, 200, 0, 0, 0, 0}));
    exchange(driver), exchange(driver);
    ASSERT_TRUE(cap.push({0, 0, 0, 0, 0, 0}));
    exchange(driver);
    ASSERT_TRUE(cap.press(2));
    exchange(driver);
    const Vec3 there = position();
    EXPECT_GT(there.z, start().z) << "toward the user";
    for (int i = 0; i < 2000; ++i)
        ASSERT_EQ(exchange(driver), DeviceStage::ready);
    EXPECT_EQ(position(), there);
    EXPECT_EQ(state_.fresh, 1u);
    EXPECT_EQ(why_, "") << "a cap at rest says nothing, and that is no fault";
    EXPECT_EQ(state_.buttons, 2u);
}

TEST_F(SpaceMouseDriver, SilenceWithDeflectedCapCountsAsRelease) {
    SpaceMouseEmulator cap(Age::recent);
    SpaceMouse driver(clock_);
    ASSERT_EQ(driver.open(why_), DeviceStage::ready);
    ASSERT_TRUE(cap.push({350, 0, 0, 0, 0, 0}));
    std::string said;
    for (int i = 0; i < 1000; ++i) {
        exchange(driver);
        if (!why_.empty()) said = why_;
    }
    EXPECT_NEAR(position().x, 0.150 * rate_.speed_m_s, 0.003 * rate_.speed_m_s);
    EXPECT_NE(said.find("stopped sending"), std::string::npos);
}

TEST_F(SpaceMouseDriver, ClockJumpCausesNoLargeMotion) {
    SpaceMouseEmulator cap(Age::recent);
    SpaceMouse driver(clock_);
    ASSERT_EQ(driver.open(why_), DeviceStage::ready);
    ASSERT_TRUE(cap.push({350, 0, 0, 0, 0, 0}));
    exchange(driver);
    for (const std::int64_t jump_ns : {3'600'000 * kMs, -3'600'000 * kMs, -kMs, 100 * kMs}) {
        const double before = position().x;
        exchange(driver, jump_ns);
        EXPECT_LE(position().x - before, 0.020 * rate_.speed_m_s + 1e-12) << jump_ns;
        EXPECT_GE(position().x, before);
        ASSERT_TRUE(cap.push({350, 0, 0, 0, 0, 0}));
    }
}

TEST_F(SpaceMouseDriver, ReportsOfAnotherDeviceEndTheConnection) {
    SpaceMouseEmulator cap(Age::recent);
    SpaceMouse driver(clock_);
    ASSERT_EQ(driver.open(why_), DeviceStage::ready);
    const std::array<unsigned char, 9> garbage{1, 0xFF, 0x7F, 3, 4, 5, 6, 7, 8};
    DeviceStage stage = DeviceStage::ready;
    for (int i = 0; i < 25 && stage == DeviceStage::ready; ++i) {
        ASSERT_TRUE(cap.garble(garbage));
        stage = exchange(driver);
    }
    EXPECT_EQ(stage, DeviceStage::failed);
    EXPECT_NE(why_.find("not those of a SpaceMouse"), std::string::npos) << why_;
    EXPECT_EQ(position(), start());
}

TEST_F(SpaceMouseDriver, UnpluggingFailsAndReconnectionKeepsThePose) {
    SpaceMouse driver(clock_);
    {
        SpaceMouseEmulator cap(Age::recent);
        ASSERT_EQ(driver.open(why_), DeviceStage::ready);
        ASSERT_TRUE(cap.push({350, 0, 0, 0, 0, 0}));
        exchange(driver), exchange(driver);
        cap.unplug();
        EXPECT_EQ(exchange(driver), DeviceStage::failed);
        EXPECT_NE(why_.find("/dev/hidraw"), std::string::npos) << why_;
        driver.close();
        EXPECT_EQ(driver.open(why_), DeviceStage::absent);
    }
    const Vec3 there = position();
    SpaceMouseEmulator again(Age::old);
    ASSERT_EQ(driver.open(why_), DeviceStage::ready) << why_;
    time_.now_ns += 60'000 * kMs;
    exchange(driver);
    EXPECT_EQ(position(), there);
}

}  // namespace
}  // namespace stylet::haptics
