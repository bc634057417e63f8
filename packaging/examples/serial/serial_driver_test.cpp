// The sample driver with a pseudo-terminal in place of the arm.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "haptics/devices/devices.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/wait_until.h"

namespace stylet::haptics {
namespace {

class Serial : public testing::Test {
  protected:
    Serial() {
        EXPECT_EQ(grantpt(arm_), 0);
        EXPECT_EQ(unlockpt(arm_), 0);
        options_.socket = ptsname(arm_);
        driver_ = makeDriver("serial", options_, clock_.clock());
        state_.fresh = 0;
    }
    ~Serial() override {
        driver_.reset();
        if (arm_ >= 0) close(arm_);
    }
    void write(const std::string& text) {
        ASSERT_EQ(::write(arm_, text.data(), text.size()), ssize_t(text.size()));
    }
    // The kernel delivers bytes a little later, so this repeats exchanges until the driver reaches `stage`.
    bool reaches(DeviceStage stage) {
        return test::waitUntil([&] { return driver_->exchange(force_n_, state_, why_) == stage; });
    }
    bool armReceives(const std::string& line) {
        return test::waitUntil([&] {
            char bytes[256];
            for (ssize_t count = 0; (count = read(arm_, bytes, sizeof bytes)) > 0;)
                received_.append(bytes, std::size_t(count));
            return received_.find(line) != std::string::npos;
        });
    }

    int arm_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    DeviceOptions options_;
    test::SteppedClock clock_;
    std::unique_ptr<Driver> driver_;
    DeviceState state_;
    Vec3 force_n_{0.0};
    std::string why_, received_;
};

TEST_F(Serial, ReadsThePositionAndSendsTheForce) {
    ASSERT_EQ(findDevices(options_).back().kind, "serial");
    ASSERT_EQ(driver_->open(why_), DeviceStage::opening) << why_;
    EXPECT_EQ(driver_->exchange({}, state_, why_), DeviceStage::opening);
    write("10 -20 30.5 3\n");
    ASSERT_TRUE(reaches(DeviceStage::ready)) << why_;
    EXPECT_EQ(state_.device_from_stylus.position_m, Vec3(0.010, -0.020, 0.0305));
    EXPECT_EQ(state_.buttons, 3u);
    EXPECT_EQ(state_.fresh, 1u);
    force_n_ = {0.0, -1.5, 0.25};
    EXPECT_EQ(driver_->exchange(force_n_, state_, why_), DeviceStage::ready);
    EXPECT_TRUE(armReceives("\n0 -1500 250\n")) << received_;
    driver_->close();
    EXPECT_TRUE(armReceives("250\n0 0 0\n")) << received_;
}

TEST_F(Serial, IgnoresInvalidLines) {
    ASSERT_EQ(driver_->open(why_), DeviceStage::opening) << why_;
    write("nan 0 0 0\n1 2 3\n0 0 500 0\n1 2 3 -1\n1 2 3 4 5\n\n" + std::string(500, '9') + "\n7 0 0 0\n");
    ASSERT_TRUE(reaches(DeviceStage::ready)) << why_;
    EXPECT_EQ(state_.device_from_stylus.position_m, Vec3(0.007, 0.0, 0.0));
}

TEST_F(Serial, ReportsSilenceAndRemoval) {
    ASSERT_EQ(driver_->open(why_), DeviceStage::opening) << why_;
    clock_.now_ns += 101'000'000;
    EXPECT_EQ(driver_->exchange({}, state_, why_), DeviceStage::failed);
    EXPECT_NE(why_.find("silent"), std::string::npos) << why_;
    ASSERT_EQ(driver_->open(why_), DeviceStage::opening) << why_;
    close(std::exchange(arm_, -1));
    EXPECT_TRUE(reaches(DeviceStage::failed));
    EXPECT_NE(why_.find("gone"), std::string::npos) << why_;
    EXPECT_EQ(makeDriver("serial", {.socket = "/nonexistent"}, clock_.clock())->open(why_),
              DeviceStage::absent);
}

}  // namespace
}  // namespace stylet::haptics
