#include "haptics/devices/falcon/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "haptics/devices/falcon/falcon.h"
#include "patient/patient.h"
#include "tests/support/stepped_clock.h"
#include "tests/support/temp_folder.h"

namespace stylet::haptics::falcon {
namespace {

// A Falcon with a wrong force scale, on a weighing scale that a person reads to the gram.
class ScaleDevice final : public HapticDevice {
  public:
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t) noexcept STYLET_NONBLOCKING override {
        DeviceState state;
        state.device_from_stylus.position_m = profile_.workspace_centre_m;
        state.flags = ++reads > lost_after && reads <= found_after ? 0 : state.flags;
        return state;
    }
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override {
        most_rise_n = std::max(most_rise_n, glm::length(force_n) - glm::length(sent_n));
        most_n = std::max(most_n, glm::length(force_n));
        sent_n = force_n;
    }
    double grams() const {
        const double newtons =
            gains.x * std::fabs(sent_n.x) + gains.y * std::fabs(sent_n.y) + gains.z * sent_n.z;
        return std::round(250.0 + newtons / 9.80665e-3);
    }

    Vec3 gains{1.0}, sent_n{0.0};
    double most_n = 0.0, most_rise_n = 0.0;
    std::int64_t reads = 0, lost_after = 1LL << 60, found_after = 1LL << 60;

  private:
    DeviceProfile profile_ = makeProfile({});
};

struct Calibrating : testing::Test {
    ScaleDevice device;
    test::SteppedClock time;
    std::int64_t asked_ns = 0;
    std::vector<std::string> said;
    bool stopped = false;
    Clock clock = time.clock();
    CalibrationPrompts prompts{[this](const std::string& text) {
                                   said.push_back(text);
                                   asked_ns = time.now_ns;
                               },
                               [this]() -> std::optional<double> {
                                   if (time.now_ns - asked_ns < 3'000'000'000) return std::nullopt;
                                   return device.grams();
                               },
                               [this] { return stopped; }};
    std::string refusal() {
        try {
            calibrate(device, clock, prompts);
        } catch (const std::runtime_error& e) {
            return e.what();
        }
        return "";
    }
};

// HZ-FORCE-22
TEST_F(Calibrating, FindsTheGainsOfAllAxesWithASlowRamp) {
    device.gains = {2.0, 0.6, 1.5};
    const Calibration calibration = calibrate(device, clock, prompts);
    EXPECT_TRUE(calibration.measured);
    EXPECT_NEAR(calibration.measured_per_asked.x, 2.0, 0.005);
    EXPECT_NEAR(calibration.measured_per_asked.y, 0.6, 0.005);
    EXPECT_NEAR(calibration.measured_per_asked.z, 1.5, 0.005);
    EXPECT_LE(device.most_n, 3.0 + 1e-9);
    EXPECT_LE(device.most_rise_n, 0.005);
    EXPECT_EQ(device.sent_n, Vec3(0.0));
    EXPECT_EQ(said.size(), 15u);
    // With the calibration, the motor commands produce the requested force.
    const auto plain = computeMotorCounts({0.0, 0.0, 3.0}, kCentre_m, {}),
               mended = computeMotorCounts({0.0, 0.0, 3.0}, kCentre_m, calibration);
    EXPECT_NEAR(double(plain[0]) / mended[0], 1.5, 0.02);
}

// HZ-FORCE-22
TEST_F(Calibrating, EndsInZeroForceWithAReasonWhenTheDeviceIsLostOrTheUserStops) {
    device.lost_after = 12'000;
    EXPECT_THAT(refusal(), testing::HasSubstr("y"));
    EXPECT_EQ(device.sent_n, Vec3(0.0));
    EXPECT_GT(device.most_n, 0.5);
    EXPECT_THAT(said, testing::Contains(testing::HasSubstr("not ready")).Times(4));
    device.lost_after = 1LL << 60;
    stopped = true;
    EXPECT_THAT(refusal(), testing::HasSubstr("stopped"));
    EXPECT_EQ(device.sent_n, Vec3(0.0));
}

TEST_F(Calibrating, FaultRestartsOnlyTheCurrentAxis) {
    device.gains = {2.0, 0.6, 1.5};
    device.lost_after = 25'000;  // while the second axis is pushing
    device.found_after = 25'100;
    const Calibration calibration = calibrate(device, clock, prompts);
    EXPECT_NEAR(calibration.measured_per_asked.x, 2.0, 0.005);
    EXPECT_NEAR(calibration.measured_per_asked.y, 0.6, 0.005);
    EXPECT_NEAR(calibration.measured_per_asked.z, 1.5, 0.005);
    EXPECT_THAT(said, testing::Contains(testing::HasSubstr("This axis once more")).Times(1));
    EXPECT_GT(said.size(), 16u);
    EXPECT_LT(said.size(), 22u) << "the first axis is kept";
    EXPECT_LE(device.most_rise_n, 0.005);
}

TEST_F(Calibrating, FaultWithoutRequestedForceHasNoConsequence) {
    device.lost_after = 1'000;
    device.found_after = 1'500;
    EXPECT_TRUE(calibrate(device, clock, prompts).measured);
    EXPECT_EQ(said.size(), 15u);
}

// HZ-RECORD-13
TEST(CalibrationFile, IsReplacedAtomicallyAndCheckedInAdvance) {
    const test::TempFolder folder;
    const std::filesystem::path file = folder / "falcon.toml";
    checkCalibrationFile(file);
    EXPECT_FALSE(std::filesystem::exists(file));
    Calibration calibration;
    calibration.measured_per_asked = {1.0, 2.0, 3.0};
    saveCalibration(file, calibration);
    checkCalibrationFile(file);
    EXPECT_EQ(loadCalibration(file).measured_per_asked.z, 3.0) << "the trial leaves it";
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1)
        << "nothing beside it";
    const std::filesystem::path nowhere = folder / "none" / "falcon.toml";
    EXPECT_THROW(checkCalibrationFile(nowhere), DataError);
    EXPECT_THROW(saveCalibration(nowhere, calibration), DataError);
    EXPECT_THROW(checkCalibrationFile(folder.path()), DataError) << "a folder";
}

TEST(CalibrationFile, KeepsUserFilesAndLeavesNoTemporaryFile) {
    const test::TempFolder folder;
    const std::filesystem::path file = folder / "falcon.toml", users = folder / "falcon.toml.new";
    const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder.path()), {}); };
    std::ofstream(users) << "mine";
    checkCalibrationFile(file);
    EXPECT_EQ(files(), 1);
    saveCalibration(file, {});
    EXPECT_EQ(files(), 2);
    std::string text;
    std::ifstream(users) >> text;
    EXPECT_EQ(text, "mine");
    std::filesystem::remove(file);
    std::filesystem::create_directory(file);
    EXPECT_THROW(saveCalibration(file, {}), DataError);
    EXPECT_EQ(files(), 2) << "not the half of a save that failed";
}

// HZ-FORCE-22
TEST_F(Calibrating, ImplausibleReadingsAreRefused) {
    device.gains = {1.0, 0.0, 1.0};
    EXPECT_THAT(refusal(), testing::HasSubstr("y"));
}

}  // namespace
}  // namespace stylet::haptics::falcon
