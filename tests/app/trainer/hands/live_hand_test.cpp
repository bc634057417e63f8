#include "app/trainer/hands/live_hand.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "app/trainer/stores/platform_linux.h"

namespace stylet::trainer {
namespace {

using namespace std::chrono_literals;

// A ready device whose calls last as long as the test wants.
class SlowDriver final : public haptics::Driver {
  public:
    SlowDriver(const std::atomic<bool>& blocks, std::atomic<bool>& blocked)
        : blocks_(blocks), blocked_(blocked) {}
    const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
    haptics::DeviceStage open(std::string&) override { return haptics::DeviceStage::ready; }
    haptics::DeviceStage exchange(const Vec3&, haptics::DeviceState&, std::string&) override {
        while (blocks_) {
            blocked_ = true;
            std::this_thread::sleep_for(1ms);
        }
        blocked_ = false;
        return haptics::DeviceStage::ready;
    }
    void close() noexcept override {}

  private:
    const std::atomic<bool>& blocks_;
    std::atomic<bool>& blocked_;
    haptics::DeviceProfile profile_;
};

TEST(LiveDevice, ReportsOnceThatItIsSlow) {
    std::atomic<bool> blocks = false, blocked = false;
    LiveDevice device("slow", std::make_unique<SlowDriver>(blocks, blocked), monotonicClock());
    const auto waitFor = [&](bool wanted) {
        for (int i = 0; i < 10'000 && blocked != wanted; ++i)
            std::this_thread::sleep_for(1ms);
        return blocked == wanted;
    };
    testing::internal::CaptureStderr();
    ASSERT_TRUE(device.waitUntilReady([] { return false; }));
    for (int times = 0; times < 3; ++times) {
        blocks = true;
        ASSERT_TRUE(waitFor(true));
        std::this_thread::sleep_for(std::chrono::nanoseconds(haptics::kDriverDeadline_ns) + 20ms);
        device.reportStateChanges();
        blocks = false;
        ASSERT_TRUE(waitFor(false));
        device.reportStateChanges();
    }
    device.stop();
    EXPECT_THAT(testing::internal::GetCapturedStderr(),
                testing::EndsWith("stylet: slow: ready\n"
                                  "stylet: slow: ready (it has not answered for some time)\n"));
}

}  // namespace
}  // namespace stylet::trainer
