// Runs the real driver through libusb down to the kernel's requests, which umockdev answers. Tests that
// depend on milliseconds are in falcon_test.cpp.
#include "haptics/devices/falcon/falcon_usb.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "haptics/devices/devices.h"
#include "haptics/devices/falcon/falcon.h"
#include "haptics/devices/polled.h"
#include "patient/patient.h"
#include "tests/support/constants.h"
#include "tests/support/falcon_testbed.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/wait_until.h"

namespace stylet::haptics::falcon {
namespace {

using test::FalconEmulator;
using test::kMs;
using testing::HasSubstr;

// The test's thread polls the device and advances its clock. libusb's waits of 3 ms are real time, but the
// Falcon's allowed silence is counted in exchanges.
struct FalconUsb : testing::Test {
    void SetUp() override {
        if (!test::FalconTestbed::works()) GTEST_SKIP() << "umockdev's library is not preloaded: use ctest";
    }
    PolledDevice device(Settings settings = {}) {
        PolledSettings polled;
        polled.absent_retry_ns = polled.backoff_first_ns = 50 * kMs;
        polled.backoff_max_ns = 100 * kMs;
        return {std::make_unique<FalconDriver>(usbBus(), time.clock(), std::move(settings)), time.clock(),
                polled};
    }
    // Reads and sends like the haptic loop, until `done` returns true or a minute has passed.
    bool loop(PolledDevice& device, const Vec3& force_n,
              const std::function<bool(const DeviceState&)>& done) {
        return test::waitUntil([&] {
            const DeviceState state = device.read(time.now_ns);
            device.send(force_n);
            if (done(state)) return true;
            time.advancePeriod(device.poll());
            return false;
        });
    }
    bool reaches(PolledDevice& device, DeviceStage stage) {
        return loop(device, Vec3(0.0), [&](const DeviceState&) { return device.stage() == stage; });
    }
    static bool isReady(const DeviceState& state) { return (state.flags & kDeviceReady) != 0; }

    test::SteppedClock time;
};

TEST_F(FalconUsb, IsFoundByVendorAndProductId) {
    test::FalconTestbed bed(true);
    EXPECT_TRUE(findFalcons().empty());
    bed.plugIn();
    ASSERT_EQ(findFalcons().size(), 1u);
    EXPECT_EQ(findFalcons()[0].port, "1-3");
    EXPECT_EQ(findFalcons()[0].node, "/dev/bus/usb/001/004");
    std::string why;
    EXPECT_EQ(usbBus("1-3")->open(why), DeviceStage::opening) << why;
    EXPECT_EQ(usbBus("1-4")->open(why), DeviceStage::absent);
    EXPECT_THAT(why, HasSubstr("no Falcon"));
}

TEST_F(FalconUsb, IsListedAmongTheDevices) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    const auto problem = [](const DeviceOptions& options) {
        for (const FoundDevice& found : findDevices(options))
            if (found.kind == "falcon") return found.problem;
        return std::string("not found");
    };
    EXPECT_THAT(problem({}), HasSubstr("--firmware"));
    EXPECT_EQ(problem({.firmware = "image.bin"}), "");
    EXPECT_EQ(deviceProfile("falcon", {}).force_peak_n, 8.0);
    std::string why;
    const auto driver = makeDriver("falcon", {}, time.clock());
    EXPECT_EQ(driver->open(why), DeviceStage::opening) << why;
    EXPECT_THROW(makeDriver("falcon", {.firmware = "/nonexistent"}, time.clock()), DataError);
    EXPECT_THROW(makeDriver("falcon", {.calibration = "/nonexistent"}, time.clock()), DataError);
}

TEST_F(FalconUsb, HomesAppliesForceAndClosesWithZero) {
    test::FalconTestbed bed(true);
    bed.plugIn();
    PolledDevice falcon = device();
    ASSERT_TRUE(reaches(falcon, DeviceStage::needsHoming)) << falcon.report().why;
    bed.with([](FalconEmulator& f) { f.home(); });
    Vec3 grip(0.0);
    ASSERT_TRUE(loop(falcon, Vec3(0.0), [&](const DeviceState& state) {
        grip = state.device_from_stylus.position_m;
        return isReady(state);
    })) << falcon.report().why;
    EXPECT_NEAR(grip.z, 0.11, 1e-4);
    ASSERT_TRUE(loop(falcon, {0.0, 0.0, -2.0}, [&](const DeviceState&) {
        return bed.with([](FalconEmulator& f) { return f.hasMotorForce(); });
    }));
    const auto expected = computeMotorCounts({0.0, 0.0, -2.0}, grip, {});
    bed.with([&](FalconEmulator& f) {
        EXPECT_EQ(f.motors(), (std::array<int, 3>{expected[0], expected[1], expected[2]}));
        EXPECT_EQ(f.bad_packets, 0);
    });
    falcon.stop();
    bed.with([](FalconEmulator& f) { EXPECT_FALSE(f.hasMotorForce()); });
}

TEST_F(FalconUsb, FirmwareIsLoadedOverUsb) {
    test::FalconTestbed bed(false);
    bed.with([](FalconEmulator& f) { f.image_bytes = 1000; });
    bed.plugIn();
    std::vector<std::uint8_t> image(1000);
    for (std::size_t i = 0; i < image.size(); ++i)
        image[i] = std::uint8_t(i * 7 + i / 256);
    PolledDevice falcon = device({.firmware = {image, ""}});
    time.read_cost_ns = kMs;  // nothing answers: each read of the clock advances it
    ASSERT_TRUE(reaches(falcon, DeviceStage::needsFirmware)) << falcon.report().why;
    time.read_cost_ns = 0;
    ASSERT_TRUE(reaches(falcon, DeviceStage::needsHoming)) << falcon.report().why;
    bed.with([&](FalconEmulator& f) { EXPECT_EQ(f.image(), image); });
}

TEST_F(FalconUsb, UsbFaultsEndInZeroForceAreReportedAndRecover) {
    struct CableFault {
        const char* name;
        std::function<void(FalconEmulator&)> begin;
        const char* cause;
        bool hears;  // whether a zero force can reach it
    };
    const CableFault injections[] = {
        {"silent", [](FalconEmulator& f) { f.faults.silent = true; }, "stopped answering", true},
        {"mute", [](FalconEmulator& f) { f.faults.mute = true; }, "stopped answering", true},
        {"deaf", [](FalconEmulator& f) { f.faults.deaf = true; }, "stopped answering", false},
        {"corrupt",
         [](FalconEmulator& f) {
             f.faults.xor_count = 1 << 30;
             f.faults.xor_byte = 6;
             f.faults.xor_mask = 0x80;
         },
         "garbled", true},
        {"jump", [](FalconEmulator& f) { f.moveTo({30000, -516, -516}); }, "encoders", true},
        {"unplugged", [](FalconEmulator& f) { f.faults.unplug_after_bytes = 7; }, "unplugged", false},
    };
    test::FalconTestbed bed(true);
    bed.plugIn();
    PolledDevice falcon = device();
    for (const CableFault& injection : injections) {
        SCOPED_TRACE(injection.name);
        ASSERT_TRUE(reaches(falcon, DeviceStage::needsHoming)) << falcon.report().why;
        bed.with([](FalconEmulator& f) { f.home(); });
        ASSERT_TRUE(reaches(falcon, DeviceStage::ready)) << falcon.report().why;
        ASSERT_TRUE(loop(falcon, {0.0, 0.0, -2.0}, [&](const DeviceState&) {
            return bed.with([](FalconEmulator& f) { return f.hasMotorForce(); });
        }));
        bed.with(injection.begin);
        time.read_cost_ns = kMs;  // each read of the clock advances it
        std::string why;
        bool zero = false;
        ASSERT_TRUE(loop(falcon, {0.0, 0.0, -2.0}, [&](const DeviceState&) {
            zero = zero || bed.with([](FalconEmulator& f) { return !f.hasMotorForce(); });
            why = falcon.report().why;
            return falcon.stage() == DeviceStage::failed;
        }));
        time.read_cost_ns = 0;
        EXPECT_THAT(why, HasSubstr(injection.cause));
        EXPECT_FALSE(isReady(falcon.read(0)));
        if (injection.hears) {
            EXPECT_TRUE(zero);
        }
        bed.with([](FalconEmulator& f) {
            f = FalconEmulator(true);
            f.control(3, 2);
        });
    }
}

TEST_F(FalconUsb, ReconnectsWhenPluggedInAgain) {
    test::FalconTestbed bed(true);
    PolledDevice falcon = device();
    ASSERT_TRUE(loop(falcon, Vec3(0.0), [&](const DeviceState&) { return falcon.report().opens > 0; }));
    EXPECT_EQ(falcon.stage(), DeviceStage::absent);
    for (int i = 0; i < 3; ++i) {
        bed.with([](FalconEmulator& f) { f = FalconEmulator(true); });
        bed.plugIn();
        ASSERT_TRUE(reaches(falcon, DeviceStage::needsHoming)) << falcon.report().why;
        bed.with([](FalconEmulator& f) { f.home(); });
        ASSERT_TRUE(reaches(falcon, DeviceStage::ready)) << falcon.report().why;
        bed.plugOut();
        ASSERT_TRUE(reaches(falcon, DeviceStage::absent)) << falcon.report().why;
        EXPECT_FALSE(isReady(falcon.read(0)));
    }
}

}  // namespace
}  // namespace stylet::haptics::falcon
