// The frame loop with a phantom, from the haptic loop's output to the pictures that the mock runtime
// captured.
#include "app/trainer/display/frames.h"

#include "app/trainer/display/mock_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>

#include <gtest/gtest.h>
#include <vulkan/vulkan_raii.hpp>

#include "base/statistics.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/support/duct_path.h"
#include "tests/support/phantom.h"
#include "tests/support/picture.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using patient::Tissue;

// Layers along +x, 100 mm in total. The skin's surface is at x = 0, the duct at 50 mm.
patient::Package layeredPhantom() {
    return test::makeSlabs({{Tissue::skin, 0.002},
                            {Tissue::soft, 0.018},
                            {Tissue::fascia, 0.002},
                            {Tissue::liver, 0.028},
                            {Tissue::duct, 0.006},
                            {Tissue::liver, 0.044}},
                           0.001);
}

// The needle on the path, with its tip at `depth_m` below the skin.
FrameState needleAt(double depth_m) {
    FrameState seen;
    haptics::TickOutput& shown = seen.tick;
    shown.patient_from_needle.position_m = {depth_m, 0.0, 0.0};
    shown.patient_from_needle.rotation =
        Quat{std::sqrt(0.5), 0.0, -std::sqrt(0.5), 0.0};  // +z -> -x: toward the hub
    shown.depth_m = depth_m;
    return seen;
}

struct GreyPicture {
    int width = 0, height = 0;
    std::vector<double> grey;
    double at(int x, int y) const { return grey[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

GreyPicture loadGrey(const std::filesystem::path& file) {
    const test::Picture picture = test::loadPicture(file);
    GreyPicture grey{picture.width, picture.height, {}};
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
        grey.grey.push_back((picture.rgb[i] + picture.rgb[i + 1] + picture.rgb[i + 2]) / 3.0);
    return grey;
}

double deviation(const std::vector<double>& values) {
    return sampleDeviation(values, mean(values));
}

// Disparity of the patch around (x, y) in the left picture: how far to the left its best match lies in the
// same row of the right picture.
int disparityAt(const GreyPicture& left, const GreyPicture& right, int x, int y) {
    constexpr int kHalf = 20, kMost = 200;
    int best = -1;
    double best_error = 1e300;
    for (int shift = 0; shift <= kMost && x - kHalf - shift >= 0; ++shift) {
        double error = 0.0;
        for (int dy = -kHalf; dy <= kHalf; ++dy)
            for (int dx = -kHalf; dx <= kHalf; ++dx)
                error += std::abs(left.at(x + dx, y + dy) - right.at(x + dx - shift, y + dy));
        if (error < best_error) best_error = error, best = shift;
    }
    return best;
}

// Projects a point of the stage into an eye's picture, with the fields of view of the scenario's head.
std::array<double, 2> project(const Pose& stage_from_head, int eye, const Vec3& p, int size) {
    const double to_side_m = (eye == 0 ? -0.5 : 0.5) * kMockEyeDistance_m;
    const Pose head_from_eye{Quat{1, 0, 0, 0}, {to_side_m, 0.0, 0.0}};
    const Vec3 seen = (stage_from_head * head_from_eye).inverse() * p;
    const auto& [left, right, up, down] = kMockEyeAngles_rad[eye];
    const double u = (seen.x / -seen.z - std::tan(left)) / (std::tan(right) - std::tan(left));
    const double v = (std::tan(up) - seen.y / -seen.z) / (std::tan(up) - std::tan(down));
    return {u * size, v * size};
}

bool validationLayerPresent() {
    for (const auto& layer : vk::raii::Context().enumerateInstanceLayerProperties())
        if (std::string(layer.layerName.data()) == "VK_LAYER_KHRONOS_validation") return true;
    return false;
}

class FramesTest : public testing::Test {
  protected:
    void SetUp() override {
        setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
        settings_.assets = std::getenv("STYLET_ASSETS");
        settings_.config.fast = true;
        settings_.config.folder = folder_.path();
        settings_.config.difficulties = test::difficulties();
        settings_.config.validation = validationLayerPresent();
        settings_.config.stats = true;
        settings_.field = fieldOf(path_);
    }
    void makeFiveFrames() {
        FrameLoop loop(patient_, settings_, path_);
        EXPECT_TRUE(loop.frame(needleAt(-0.01), nullptr, ""));
        EXPECT_TRUE(loop.frame(needleAt(0.001), nullptr, "skin"));
        EXPECT_TRUE(loop.frame(needleAt(0.02), nullptr, ""));
        EXPECT_TRUE(loop.frame(needleAt(0.052), nullptr, "duct"));
        EXPECT_TRUE(loop.frame(needleAt(0.052), nullptr, ""));
        const FrameTotals totals = loop.totals();
        EXPECT_GE(totals.frames, 5u);
        EXPECT_GE(totals.rendered, 3u);
        EXPECT_EQ(totals.validation_messages, 0u);
        EXPECT_GT(totals.sum.samples, 0u);
        ASSERT_EQ(totals.times.size(), totals.rendered);
        for (const FrameTime& time : totals.times) {
            EXPECT_GT(time.frame_ms, time.volume_ms);
            EXPECT_GT(time.volume_ms, 0.0);
        }
        EXPECT_EQ(totals.runtime, "XR Mock");
        EXPECT_FALSE(totals.gpu.empty());
    }

    const patient::Package package_ = layeredPhantom();
    const patient::Patient patient_{package_};
    const patient::PlannedPath path_ = test::ductPath();
    test::TempFolder folder_;
    PictureSettings settings_;
};

TEST_F(FramesTest, CapturesAreInStereoAndWorkTwiceInAProcess) {
    const Pose stage_from_patient = stageFromPatient(patient_, fieldOf(path_));
    const Pose stage_from_head = stageFromHead(stage_from_patient, fieldOf(path_), 1.0);
    for (int round = 0; round < 2; ++round) {
        SCOPED_TRACE(round);
        makeFiveFrames();
        for (const std::string moment : {"skin", "duct"}) {
            SCOPED_TRACE(moment);
            const GreyPicture left = loadGrey(folder_ / (moment + "_left.png"));
            const GreyPicture right = loadGrey(folder_ / (moment + "_right.png"));
            ASSERT_EQ(left.width, 640);
            ASSERT_EQ(right.height, 640);
            EXPECT_GT(deviation(left.grey), 5.0);
            EXPECT_GT(deviation(right.grey), 5.0);
            // The entry point must have the disparity of its projected positions in both pictures.
            const Vec3 entry = stage_from_patient * path_.entry_m;
            const auto in_left = project(stage_from_head, 0, entry, 640);
            const auto in_right = project(stage_from_head, 1, entry, 640);
            const int disparity = disparityAt(left, right, int(in_left[0]), int(in_left[1]));
            EXPECT_NEAR(disparity, in_left[0] - in_right[0], 8.0);
        }
        std::filesystem::remove(folder_ / "skin_left.png");
        std::filesystem::remove(folder_ / "duct_left.png");
    }
    if (!settings_.config.validation)
        GTEST_SKIP() << "VK_LAYER_KHRONOS_validation is not installed: messages were not counted";
}

// The head looks at the entry point, so the equipment's screens are not visible. A capture still saves
// their pictures.
TEST_F(FramesTest, ACaptureSavesTheEquipmentPictures) {
    FrameLoop loop(patient_, settings_, path_);
    FrameState seen = needleAt(0.02);
    seen.tick.probe_parked = true;
    seen.tick.patient_from_probe = {Quat{std::sqrt(0.5), 0.0, std::sqrt(0.5), 0.0}, Vec3(0.001, 0.0, 0.0)};
    seen.equipment.xray.pedal = true;
    seen.equipment.xray.pulses = 1;
    EXPECT_TRUE(loop.frame(seen, nullptr, ""));
    EXPECT_EQ(loop.totals().equipment.scans, 0u);
    EXPECT_EQ(loop.totals().equipment.xray_pictures, 0u);
    EXPECT_TRUE(loop.frame(seen, nullptr, "liver"));
    EXPECT_EQ(loop.totals().equipment.scans, 1u);
    EXPECT_EQ(loop.totals().equipment.xray_pictures, 1u);
    EXPECT_GT(deviation(loadGrey(folder_ / "liver_ultrasound.png").grey), 10.0);
    EXPECT_GT(deviation(loadGrey(folder_ / "liver_xray.png").grey), 10.0);
    EXPECT_EQ(loop.totals().validation_messages, 0u);
}

TEST_F(FramesTest, TheEntryPointIsVisibleToBothEyes) {
    const Pose stage_from_patient = stageFromPatient(patient_, fieldOf(path_));
    EXPECT_NEAR((stage_from_patient * Vec3(0.0, -test::kSlabHalfWidth_m, 0.0)).y, kTableHeight_m, 0.001);
    // The patient's front is up, the right side faces the operator, and the head is to the operator's left.
    EXPECT_GT(stage_from_patient.direction({0, 1, 0}).y, 0.999);
    EXPECT_GT(stage_from_patient.direction({1, 0, 0}).z, 0.999);
    EXPECT_LT(stage_from_patient.direction({0, 0, 1}).x, -0.999);
    for (double t_s = 0.0; t_s < 120.0; t_s += 0.5) {
        const Pose head = stageFromHead(stage_from_patient, fieldOf(path_), t_s);
        for (int eye = 0; eye < 2; ++eye)
            for (const Vec3& p : {path_.entry_m, path_.target_m, Vec3(-0.20, 0.0, 0.0)}) {
                const auto at = project(head, eye, stage_from_patient * p, 640);
                EXPECT_GT(std::min(at[0], at[1]), 40.0) << t_s;
                EXPECT_LT(std::max(at[0], at[1]), 600.0) << t_s;
            }
        const double distance_m = glm::length(head.position_m - stage_from_patient * path_.entry_m);
        EXPECT_GT(distance_m, 0.45);
        EXPECT_LT(distance_m, 0.60);
    }
}

TEST_F(FramesTest, ACaptureThatWasNotRenderedIsReported) {
    settings_.head_script = folder_ / "hidden.json";
    std::ofstream(settings_.head_script) << R"({"version": 1, "head": [{"t_s": 0, "position": [0, 1.5, 0]}],
               "session": [{"t_s": 0, "state": "synchronized"}]})";
    FrameLoop loop(patient_, settings_, path_);
    testing::internal::CaptureStderr();
    EXPECT_TRUE(loop.frame(needleAt(-0.01), nullptr, ""));
    EXPECT_TRUE(loop.frame(needleAt(0.001), nullptr, "skin"));
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("no picture of capture \"skin\""), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_EQ(loop.totals().rendered, 0u);
}

TEST_F(FramesTest, OtherRuntimesAreNotTreatedAsTheMock) {
    EXPECT_TRUE(isMockRuntimeSelected());
    setenv("XR_RUNTIME_JSON", "/nowhere/runtime.json", 1);
    EXPECT_FALSE(isMockRuntimeSelected());
}

}  // namespace
}  // namespace stylet::trainer
