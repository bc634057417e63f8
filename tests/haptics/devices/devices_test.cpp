// The registry with emulated devices plugged in.
#include "haptics/devices/devices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "patient/patient.h"
#include "tests/haptics/devices/wooden_json.h"
#include "tests/support/hid_testbed.h"
#include "tests/support/refused.h"
#include "tests/support/spacemouse_emulator.h"
#include "tests/support/temp_folder.h"
#include "tests/support/woodenhaptics_emulator.h"

namespace stylet::haptics {
namespace {

class Devices : public testing::Test {
  protected:
    void SetUp() override {
        if (!test::underUmockdev()) GTEST_SKIP() << "not run under umockdev";
        std::ofstream(folder_ / "arm.json") << test::woodenJson();
    }
    static std::vector<FoundDevice> found(const std::string& kind, const DeviceOptions& options = {}) {
        std::vector<FoundDevice> all = findDevices(options);
        std::erase_if(all, [&](const FoundDevice& f) { return f.kind != kind; });
        return all;
    }
    const test::TempFolder folder_;
    const Clock clock_;
};

TEST_F(Devices, EveryKindHasANameATextAndLimits) {
    EXPECT_GE(deviceKinds().size(), 3u);
    for (const DeviceKind& kind : deviceKinds()) {
        ASSERT_EQ(kind.missing, nullptr) << kind.name << " is not in this build";
        EXPECT_NE(std::string(kind.what), "");
        const DeviceProfile profile = deviceProfile(kind.name, {});
        EXPECT_NE(std::string(profile.source), "") << kind.name;
        EXPECT_GE(profile.force_axes, 0);
    }
}

TEST_F(Devices, ListsPluggedInDevicesAndTheirProblems) {
    EXPECT_TRUE(found("woodenhaptics").empty());
    EXPECT_TRUE(found("spacemouse").empty());
    const test::WoodenHapticsEmulator board;
    const test::SpaceMouseEmulator cap(test::SpaceMouseEmulator::Age::recent);
    const test::HidNode keyboard({0x046d, 0xc31c, "Logitech", "Keyboard", {0x05, 0x01, 0x09, 0x06}});

    ASSERT_EQ(found("spacemouse").size(), 1u);
    const FoundDevice mouse = found("spacemouse").front();
    EXPECT_EQ(mouse.place, cap.path());
    EXPECT_EQ(mouse.what, "SpaceMouse Compact (256f:c635)");
    EXPECT_EQ(mouse.problem, "");

    ASSERT_EQ(found("woodenhaptics").size(), 1u);
    EXPECT_NE(found("woodenhaptics").front().problem.find("--device-model"), std::string::npos);
    EXPECT_EQ(found("woodenhaptics", {.model = folder_ / "arm.json"}).front().problem, "");
}

TEST_F(Devices, ModelFileSetsTheForceLimits) {
    EXPECT_TRUE(std::isnan(deviceProfile("woodenhaptics", {}).force_peak_n));
    const DeviceProfile profile = deviceProfile("woodenhaptics", {.model = folder_ / "arm.json"});
    EXPECT_EQ(profile.force_peak_n, 5.0);
    EXPECT_EQ(profile.workspace_radius_m, 0.1);
    EXPECT_GT(profile.resolution_m, 1e-5);
}

TEST_F(Devices, MakesADriverOrReportsTheMissingPart) {
    EXPECT_NE(makeDriver("spacemouse", {}, clock_), nullptr);
    EXPECT_NE(makeDriver("woodenhaptics", {.model = folder_ / "arm.json"}, clock_), nullptr);
    test::expectRefused([&] { makeDriver("woodenhaptics", {}, clock_); }, "woodenhaptics", "--device-model");
    test::expectRefused([&] { makeDriver("woodenhaptics", {.model = "/nonexistent"}, clock_); },
                        "/nonexistent", "file");
    test::expectRefused([&] { makeDriver("joystick", {}, clock_); }, "joystick", "device: not among: ");
}

}  // namespace
}  // namespace stylet::haptics
