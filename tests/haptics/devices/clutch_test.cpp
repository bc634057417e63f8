#include "haptics/devices/clutch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptics/devices/profiles.h"
#include "haptics/output/output.h"
#include "haptics/output/safety.h"
#include "patient/synth/random.h"
#include "tests/support/constants.h"

namespace stylet::haptics {
namespace {

using test::kMs;

constexpr std::uint32_t kButton = 4;

// A grip at a position that the test sets.
class Grip final : public HapticDevice {
  public:
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override { return state; }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { sent_n = force_n; }
    DeviceState state;
    Vec3 sent_n{0.0};

  private:
    DeviceProfile profile_ = [] {
        DeviceProfile profile = *findProfile("falcon");
        profile.workspace_centre_m = {0.0, 0.0, 0.1225};
        return profile;
    }();
};

struct Clutched : testing::Test {
    Clutched() { grip.state.device_from_stylus.position_m = grip.profile().workspace_centre_m; }
    Grip grip;
    ClutchedDevice device{grip, {}, Pose{}};
    std::int64_t now_ns = 0;

    // Moves straight to `to` by at most a millimetre per tick. Returns the tip's largest movement in a
    // tick.
    double moveTo(const Vec3& to, std::uint32_t buttons) {
        double most = 0.0;
        const Vec3 from = grip.state.device_from_stylus.position_m;
        const int ticks = int(std::ceil(glm::length(to - from) / 0.001)) + 1;
        for (int i = 1; i <= ticks; ++i) {
            const Vec3 before = tip();
            grip.state.device_from_stylus.position_m = from + (to - from) * (double(i) / ticks);
            grip.state.buttons = buttons;
            read();
            most = std::max(most, glm::length(tip() - before));
        }
        return most;
    }
    DeviceState read() {
        last = device.read(now_ns += kMs);
        return last;
    }
    Vec3 tip() const { return last.device_from_stylus.position_m; }
    Vec3 sent(const Vec3& force_n) {
        device.send(force_n);
        return grip.sent_n;
    }
    DeviceState last;
};

TEST_F(Clutched, WithoutClutchingTipFollowsGripUnscaled) {
    grip.state.device_from_stylus.position_m = {0.01, 0.02, 0.12};
    read();
    moveTo({0.0, -0.01, 0.10}, 0);
    EXPECT_NEAR(glm::length(tip() - Vec3(0.0, -0.01, 0.10)), 0.0, 1e-15);
    EXPECT_EQ(last.flags, grip.state.flags | kDeviceClutch);
    EXPECT_EQ(last.grip_m(), grip.state.device_from_stylus.position_m);
    EXPECT_EQ(sent({0.0, 0.0, 3.0}), Vec3(0.0, 0.0, 3.0)) << "what the output stage says";
}

// A 90 mm path on a device with 80 mm of travel. The second stroke continues where the first ended.
TEST_F(Clutched, TwoStrokesExtendThePathBeyondTheWorkspace) {
    const Vec3 near(0.0, 0.0, 0.1575), far(0.0, 0.0, 0.0900);
    grip.state.device_from_stylus.position_m = near;
    read();
    EXPECT_LE(moveTo(far, 0), 0.001 + 1e-12);
    const Vec3 held = tip();
    EXPECT_EQ(moveTo(near + Vec3(0.01, -0.005, 0.0), kButton), 0.0);  // sideways as well
    EXPECT_EQ(tip(), held);
    EXPECT_EQ(moveTo(near + Vec3(0.01, -0.005, 0.0), 0), 0.0);  // clutch released
    EXPECT_LE(moveTo(near + Vec3(0.01, -0.005, -0.0225), 0), 0.001 + 1e-12);
    EXPECT_NEAR(tip().z, near.z - 0.090, 1e-12);
    EXPECT_NEAR(tip().x, 0.0, 1e-12);
    EXPECT_NEAR(tip().y, 0.0, 1e-12);
}

// HZ-FORCE-20
TEST_F(Clutched, ForceIsZeroWhilePressedAndRampsUpOnRelease) {
    for (int i = 0; i < 250; ++i)
        read();
    EXPECT_EQ(last.share(), 1.0);
    grip.state.buttons = kButton;
    EXPECT_EQ(read().share(), 0.0);
    grip.state.buttons = 0;
    for (int i = 1; i <= 200; ++i)
        EXPECT_NEAR(read().share(), i / 200.0, 1e-9);
}

TEST_F(Clutched, NeedleKeepsItsPositionAfterReconnection) {
    grip.state.device_from_stylus.position_m = {0.0, 0.0, 0.13};
    read();
    moveTo({0.0, 0.0, 0.10}, 0);
    grip.state.flags = 0;
    grip.state.device_from_stylus.position_m = {0.03, 0.0, 0.16};
    read();
    EXPECT_EQ(tip(), Vec3(0.0, 0.0, 0.10));
    EXPECT_EQ(last.share(), 0.0);
    grip.state.flags = kDeviceReady | kDeviceHandOn;
    read();
    EXPECT_EQ(tip(), Vec3(0.0, 0.0, 0.10));
    moveTo({0.03, 0.0, 0.15}, 0);
    EXPECT_NEAR(tip().z, 0.09, 1e-12);
}

// With the clutch, the needle can be moved anywhere, but the grip cannot. Reach and wall apply to the grip.
TEST_F(Clutched, ReachCheckAndWallUseTheGripPosition) {
    const Vec3 near(0.0, 0.0, 0.155), far(0.0, 0.0, 0.09);
    grip.state.device_from_stylus.position_m = near;
    read();
    for (int stroke = 0; stroke < 3; ++stroke) {
        moveTo(far, 0);
        moveTo(near, kButton);
    }
    moveTo(near, 0);
    EXPECT_NEAR(tip().z, -0.04, 5e-3);  // outside the device's reach
    SafetyState safety;
    EXPECT_EQ(checkDevice(safety, device.profile(), last, 1e-3), 0u);
    OutputState output;
    const auto wall_n = [&] {
        OutputTick tick;
        tick.grip_m = last.grip_m();
        tick.share = last.share();
        Vec3 force_n(0.0);
        for (int i = 0; i < 4000; ++i)
            force_n = stepOutput(output, {}, device.profile(), 1.0, tick, 1e-3);
        return force_n;
    };
    EXPECT_EQ(wall_n(), Vec3(0.0));
    moveTo({0.0, 0.0, 0.1225 + 0.039}, kButton);  // 3 mm into the wall: 0.6 N, also with the clutch pressed
    EXPECT_EQ(last.share(), 0.0);
    EXPECT_NEAR(wall_n().z, -0.6, 1e-3);
    grip.state.device_from_stylus.position_m = {0.0, 0.0, 0.1225 + 0.061};
    read();
    EXPECT_EQ(checkDevice(safety, device.profile(), last, 1.0), kFaultOutOfReach);
    grip.state.device_from_stylus.position_m = {0.0, 0.0, 0.1225 + 0.059};
    read();
    EXPECT_EQ(checkDevice(safety, device.profile(), last, 1.0), 0u);
}

// A probe is held differently from a needle. The tool turns slowly in the hand, about the position of the
// needle's tip, and the grip continues as before.
TEST_F(Clutched, NewToolPoseIsApproachedGradually) {
    read();
    const Vec3 before = tip();
    const Pose wanted{{0.6, 0.0, 0.8, 0.0}, {0.03, 0.0, -0.01}};  // 106 degrees
    device.setTool(wanted);
    Pose last_pose = last.device_from_stylus;
    for (int i = 0; i < 2000; ++i) {
        const Pose now = read().device_from_stylus;
        const double cosine = std::fabs(glm::dot(now.rotation, last_pose.rotation));
        EXPECT_LE(2.0 * std::acos(std::min(1.0, cosine)), 0.001 + 1e-6);
        EXPECT_LE(glm::length(now.position_m - last_pose.position_m), 0.0001 + 1e-12);
        EXPECT_NEAR(glm::length(now.rotation), 1.0, 1e-12);
        last_pose = now;
    }
    EXPECT_EQ(last_pose.rotation, wanted.rotation);
    EXPECT_NEAR(glm::length(tip() - (before + wanted.position_m)), 0.0, 1e-15);
    moveTo(before + Vec3(0.0, 0.0, -0.02), 0);
    EXPECT_NEAR(glm::length(tip() - (before + wanted.position_m + Vec3(0.0, 0.0, -0.02))), 0.0, 1e-12);
    device.setTool(Pose{});
    for (int i = 0; i < 2000; ++i)
        read();
    EXPECT_EQ(last.device_from_stylus.rotation, Quat(1.0, 0.0, 0.0, 0.0));
}

TEST_F(Clutched, ForwardsTheInnerDeviceProfile) {
    EXPECT_EQ(device.profile().force_peak_n, 8.0);
    EXPECT_EQ(device.profile().workspace_radius_m, 0.04);
}

// There must be no wall force before the needle reaches the skin.
TEST(Placement, EntryLeavesRoomInFrontOfTheWall) {
    for (const double radius_m : {0.03, 0.08, 0.2, 0.4}) {
        DeviceProfile profile = *findProfile("falcon");
        profile.workspace_radius_m = radius_m;
        const Pose device_from_patient = alignWithPath(profile, Pose{}).inverse();
        EXPECT_EQ(workspaceWall(profile, device_from_patient * Vec3(0.0, 0.0, 0.01)).energy_j, 0.0);
        EXPECT_GT(workspaceWall(profile, device_from_patient * Vec3(0.0, 0.0, 0.012)).energy_j, 0.0);
    }
}

TEST(Placement, PutsTheEntryAtTheNearEndAndThePathThroughTheMiddle) {
    patient::synth::Random random(2, 0);
    DeviceProfile profile = *findProfile("falcon");
    profile.workspace_centre_m = {0.0, 0.0, 0.1225};
    for (int i = 0; i < 200; ++i) {
        const Vec3 axis = i == 0 ? Vec3(0.0, 1.0, 0.0) : glm::normalize(random.jitter3(1.0));
        const Vec3 across = glm::normalize(glm::cross(axis, Vec3(0.3, 0.5, 0.7)));
        const Pose at_entry{glm::quat_cast(glm::dmat3(across, glm::cross(axis, across), axis)),
                            random.jitter3(0.3)};
        const Pose patient_from_device = alignWithPath(profile, at_entry);
        EXPECT_NEAR(glm::length(patient_from_device.rotation), 1.0, 1e-12);
        const Pose device_from_patient = patient_from_device.inverse();
        // Pushing toward the device's base moves the needle in.
        EXPECT_NEAR(glm::length(device_from_patient.direction(axis) - Vec3(0.0, 0.0, 1.0)), 0.0, 1e-12);
        const Vec3 entry = device_from_patient * at_entry.position_m;
        EXPECT_NEAR(glm::length(entry - (profile.workspace_centre_m + Vec3(0.0, 0.0, 0.025))), 0.0, 1e-12);
        // A stroke of 65 mm depth stays inside the workspace.
        const Vec3 deep = device_from_patient * (at_entry.position_m - 0.065 * axis);
        EXPECT_LE(glm::length(deep - profile.workspace_centre_m), profile.workspace_radius_m + 1e-12);
        // The patient's front points up, or the head if the needle comes from the front.
        const Vec3 up = std::fabs(axis.y) < 0.9 ? Vec3(0.0, 1.0, 0.0) : Vec3(0.0, 0.0, 1.0);
        EXPECT_GT(device_from_patient.direction(up).y, 0.3);
        EXPECT_NEAR(device_from_patient.direction(up).x, 0.0, 1e-12);
    }
}

}  // namespace
}  // namespace stylet::haptics
