#include "app/trainer/session/colocation.h"

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/trainer/hands/mounted_device.h"
#include "patient/package/package.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

const Vec3 kUp(0.0, 1.0, 0.0);
// The patient's pose in the room: right side toward the operator (+z), front up.
const Pose kRoomFromPatient{Quat{std::sqrt(0.5), 0.0, -std::sqrt(0.5), 0.0}, {0.1, 1.0, -0.5}};

Registration deviceAt(const Pose& stage_from_device) {
    Registration r;
    r.key = {"falcon", "Novint Falcon", "stage", ""};
    r.stage_from_device = stage_from_device;
    r.centre_m = {0.01, -0.02, 0.03};
    r.date = "2026-11-21T20:00:00Z";
    return r;
}

// A device rotated about the vertical and tilted by a few degrees, as on an uneven table.
Pose standingTurned(double yaw_rad, double tilt_rad) {
    return {glm::angleAxis(yaw_rad, kUp) * glm::angleAxis(tilt_rad, Vec3(0.8, 0.0, 0.6)), {0.4, 0.9, -1.3}};
}

// HZ-TEACH-05
TEST(Colocation, FeltAndSeenPointsCoincideOnALevelPatient) {
    for (const double yaw : {-3.0, -1.2, 0.0, 0.7, 2.5})
        for (const double tilt : {0.0, 0.1}) {
            SCOPED_TRACE(testing::Message() << yaw << " " << tilt);
            const Registration registration = deviceAt(standingTurned(yaw, tilt));
            const Vec3 middle(0.02, 0.03, -0.01);
            const Pose patient_from_device = levelPatientFromDevice(registration, kRoomFromPatient, middle);
            EXPECT_NEAR(glm::distance(patient_from_device * registration.centre_m, middle), 0.0, 1e-12);
            const Pose room_from_stage = roomFromStage({registration, patient_from_device}, kRoomFromPatient);
            // The vertical stays exact although the device is tilted.
            EXPECT_NEAR(glm::distance(room_from_stage.direction(kUp), kUp), 0.0, 1e-12);
            for (const Vec3& p_device : {Vec3(0.0), Vec3(0.04, 0.0, 0.0), Vec3(-0.03, 0.02, 0.04)}) {
                const Vec3 felt = room_from_stage * (registration.stage_from_device * p_device);
                const Vec3 drawn = kRoomFromPatient * (patient_from_device * p_device);
                EXPECT_NEAR(glm::distance(felt, drawn), 0.0, 1e-12);
            }
            // The device's front faces the operator.
            const Vec3 front = room_from_stage.direction(registration.stage_from_device.direction({0, 0, 1}));
            EXPECT_NEAR(std::atan2(front.x, front.z), 0.0, 1e-9);
        }
}

TEST(Colocation, DeviceOnItsBackIsPlaced) {
    const Registration up =
        deviceAt({glm::angleAxis(-1.5707963267948966, Vec3(1.0, 0.0, 0.0)), {0.0, 1.0, 0.0}});
    EXPECT_NEAR(glm::distance(up.stage_from_device.direction({0, 0, 1}), kUp), 0.0, 1e-12);
    const Pose patient_from_device = levelPatientFromDevice(up, kRoomFromPatient, {});
    const Pose room_from_stage = roomFromStage({up, patient_from_device}, kRoomFromPatient);
    EXPECT_NEAR(glm::distance(room_from_stage.direction(kUp), kUp), 0.0, 1e-12);
}

TEST(Colocation, ScaleErrorVanishesAtTheCentre) {
    Registration r = deviceAt(standingTurned(0.4, 0.05));
    r.scale = 1.005;
    const Pose room_from_stage =
        roomFromStage({r, levelPatientFromDevice(r, kRoomFromPatient, {})}, kRoomFromPatient);
    const Pose patient_from_device = levelPatientFromDevice(r, kRoomFromPatient, {});
    const auto apart_mm = [&](const Vec3& p_device) {
        return 1e3 * glm::distance(room_from_stage * r.inStage({Quat{1, 0, 0, 0}, p_device}),
                                   kRoomFromPatient * (patient_from_device * p_device));
    };
    EXPECT_NEAR(apart_mm(r.centre_m), 0.0, 1e-9);
    EXPECT_NEAR(apart_mm(r.centre_m + Vec3(0.04, 0.0, 0.0)), 0.2, 1e-9);
}

// HZ-FORCE-13
TEST(RoomAlignment, FollowsAMoveAndWarns) {
    const Registration r = deviceAt(standingTurned(0.4, 0.0));
    const Colocation c{r, levelPatientFromDevice(r, kRoomFromPatient, {})};
    RoomAlignment place(c, kRoomFromPatient, false);
    EXPECT_EQ(place.begin("stage", ""), "");
    EXPECT_EQ(place.warning(), RoomWarning::unchecked) << "a stage may have been set up anew since";
    place.confirm();
    EXPECT_EQ(place.warning(), RoomWarning::none);
    const Pose before = place.roomFromStage();
    const Pose previous_from_new{glm::angleAxis(0.8, kUp), {0.5, 0.0, -0.2}};
    place.onChange(200, previous_from_new);
    place.advance(150);
    EXPECT_EQ(place.roomFromStage().position_m, before.position_m);
    EXPECT_EQ(place.warning(), RoomWarning::none);
    const std::uint64_t warningCount = place.warningCount();
    place.advance(200);
    EXPECT_EQ(place.warning(), RoomWarning::moved);
    EXPECT_EQ(place.warningCount(), warningCount + 1);
    const Vec3 p_new(0.3, 1.1, 0.2);
    const Pose after = place.roomFromStage();
    EXPECT_NEAR(glm::distance(after * p_new, before * (previous_from_new * p_new)), 0.0, 1e-12);

    // The next headset starts in the moved space and needs a new confirmation by the user.
    place.confirm();
    EXPECT_EQ(place.begin("stage", ""), "");
    EXPECT_EQ(place.warning(), RoomWarning::unchecked);
    EXPECT_NEAR(glm::distance(place.roomFromStage() * p_new, after * p_new), 0.0, 1e-12);
}

TEST(RoomAlignment, UnknownMoveCannotBeConfirmed) {
    const Registration r = deviceAt(standingTurned(0.4, 0.0));
    RoomAlignment place(Colocation{r, {}}, kRoomFromPatient, false);
    EXPECT_EQ(place.begin("stage", ""), "");
    place.confirm();
    place.onChange(300, {});
    place.advance(300);
    place.confirm();
    EXPECT_EQ(place.warning(), RoomWarning::lost);
    place.begin("stage", "");
    place.confirm();
    EXPECT_EQ(place.warning(), RoomWarning::lost) << "not by another headset either";
}

TEST(RoomAlignment, RegistrationOfAnotherSpaceIsReportedAndIgnored) {
    Registration r = deviceAt(standingTurned(0.4, 0.0));
    r.key.space = "stationary", r.key.generation = "7";
    RoomAlignment never(Colocation{r, {}}, kRoomFromPatient, false);
    EXPECT_THAT(never.begin("stationary", "8"), testing::HasSubstr("register"));
    EXPECT_EQ(never.roomFromStage().position_m, Vec3(0.0));
    never.onChange(0, {});
    never.advance(10);
    EXPECT_EQ(never.warning(), RoomWarning::none) << "nothing is used that could be wrong";

    RoomAlignment until_now(Colocation{r, {}}, kRoomFromPatient, false);
    EXPECT_EQ(until_now.begin("stationary", "7"), "");
    EXPECT_EQ(until_now.warning(), RoomWarning::none) << "the same generation is the same space";
    EXPECT_NE(until_now.begin("stationary", "8"), "");
    EXPECT_EQ(until_now.warning(), RoomWarning::lost);
}

TEST(RoomAlignment, SeatedModeLowersTheRoomOnce) {
    RoomAlignment place({}, kRoomFromPatient, true);
    EXPECT_EQ(place.begin("stage", ""), "");
    EXPECT_EQ(place.warning(), RoomWarning::none);
    place.setEyeHeight(1.18);
    EXPECT_NEAR(place.roomFromStage().position_m.y, RoomAlignment::kEyes_m - 1.18, 1e-12);
    place.setEyeHeight(1.25);
    EXPECT_NEAR(place.roomFromStage().position_m.y, RoomAlignment::kEyes_m - 1.18, 1e-12)
        << "the room must not follow the eyes";
}

// The reported tip is at its registered position, no matter how the handle is rotated.
// HZ-TEACH-05
TEST(MountedDevice, ReportsItsTip) {
    struct Handle final : haptics::HapticDevice {
        haptics::DeviceProfile p;
        haptics::DeviceState state;
        Vec3 sent{0.0};
        const haptics::DeviceProfile& profile() const noexcept override { return p; }
        haptics::DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override { return state; }
        void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override { sent = force_n; }
    } handle;
    Registration r = deviceAt(standingTurned(0.4, 0.05));
    r.stylus_from_tip_m = {0.003, -0.004, 0.01};
    MountedDevice device(handle, {.stylus_from_tip_m = r.stylus_from_tip_m});
    for (const double turn : {0.0, 0.5, 2.0}) {
        handle.state.device_from_stylus = {glm::angleAxis(turn, Vec3(0.6, 0.0, 0.8)), {0.02, 0.01, -0.03}};
        const Pose seen = device.read(0).device_from_stylus;
        EXPECT_EQ(seen.rotation, handle.state.device_from_stylus.rotation);
        EXPECT_NEAR(glm::distance(r.rigid() * seen.position_m, r.inStage(handle.state.device_from_stylus)),
                    0.0, 1e-12);
    }
    device.send({1.0, 2.0, 3.0});
    EXPECT_EQ(handle.sent, Vec3(1.0, 2.0, 3.0));
    const Pose recorded_from_device{{0.0, 0.0, 1.0, 0.0}, {0.1, -0.2, 0.3}};
    MountedDevice moved(handle, {.recorded_from_device = recorded_from_device});
    const Pose expected = recorded_from_device * handle.state.device_from_stylus;
    EXPECT_EQ(moved.read(0).device_from_stylus.position_m, expected.position_m);
    EXPECT_EQ(moved.read(0).device_from_stylus.rotation, expected.rotation);
}

TEST(RegistrationStore, TheNewestOfADeviceIsFound) {
    const test::TempFolder folder;
    EXPECT_FALSE(newestRegistration(folder / "none", "falcon", "Novint Falcon"));
    Registration r = deviceAt({});
    const auto save = [&] { saveRegistration(r, registrationFile(folder.path(), r.key)); };
    r.points = 8;
    save();
    r.key.space = "local", r.date = "2026-11-21T21:00:00Z";
    save();
    r.key.device = "inverse3", r.date = "2026-11-22T21:00:00Z";
    save();
    const auto found = newestRegistration(folder.path(), "falcon", "Novint Falcon");
    ASSERT_TRUE(found);
    EXPECT_EQ(found->key.space, "local");
    EXPECT_FALSE(newestRegistration(folder.path(), "falcon", "another"));
    std::ofstream(folder / "torn.json") << "{";
    EXPECT_TRUE(newestRegistration(folder.path(), "falcon", "Novint Falcon"))
        << "a damaged file must not hide others";
    EXPECT_THROW(newestRegistration(folder.path(), "falcon", "another"), DataError);
}

}  // namespace
}  // namespace stylet::trainer
