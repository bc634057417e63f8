// Runs the frame loop on the mock runtime's virtual clock. The scenarios cover everything that can happen to
// a headset. Checks the calls in the runtime's log.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/display/frames.h"
#include "app/trainer/view/monitor.h"
#include "render/render.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/support/duct_path.h"
#include "tests/support/phantom.h"
#include "tests/support/picture.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using patient::Tissue;

patient::Package thinPhantom() {
    return test::makeSlabs({{Tissue::skin, 0.002}, {Tissue::liver, 0.05}, {Tissue::duct, 0.006}}, 0.002);
}

FrameState outside() {
    FrameState seen;
    seen.tick.patient_from_needle.position_m = {-0.01, 0.0, 0.0};
    return seen;
}

json headKeys(const Pose& p) {
    const Vec3& at = p.position_m;
    const Quat& q = p.rotation;
    return json::array(
        {{{"t_s", 0}, {"position", {at.x, at.y, at.z}}, {"orientation", {q.x, q.y, q.z, q.w}}}});
}

class HeadsetTest : public testing::Test {
  protected:
    void SetUp() override {
        setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
        setenv("XRMOCK_LOG", (folder_ / "log.jsonl").c_str(), 1);
        settings_.assets = std::getenv("STYLET_ASSETS");
        settings_.config.fast = true;
        settings_.config.folder = folder_.path();
        settings_.config.difficulties = test::difficulties();
        settings_.config.validation = true;
        settings_.rearm_act = "press the first button";
        settings_.config.difficulty =
            training::Difficulty::exam;  // no guide panel, so every quad is a notice
        settings_.field = flankField(patient_);
        play("{}");
    }
    void TearDown() override {
        unsetenv("XRMOCK_LOG");
        unsetenv("XRMOCK_SCENARIO");
    }
    // Sets the scenario for the next instance.
    void play(const std::string& extra, int size = 128) {
        json scenario{{"version", 2},
                      {"eyes", {{"recommended_size", {size, size}}}},
                      {"head", headKeys(stageFromEyes({0.0, 1.6, 0.0}, {0.0, 1.0, -0.6}))}};
        scenario.update(json::parse(extra));
        std::ofstream(folder_ / "scenario.json") << scenario;
        setenv("XRMOCK_SCENARIO", (folder_ / "scenario.json").c_str(), 1);
    }
    void show(int frames, const std::string& moment = "") {
        if (!loop_) loop_.emplace(patient_, settings_, path_);
        for (int i = 0; i < frames; ++i)
            running_ = loop_->frame(seen_, nullptr, i + 1 == frames ? moment : "");
    }
    std::vector<json> readLog(const std::string& key) const {
        std::vector<json> lines;
        std::ifstream log(folder_ / "log.jsonl");
        for (std::string line; std::getline(log, line);)
            if (json entry = json::parse(line); entry.contains(key)) lines.push_back(std::move(entry));
        return lines;
    }
    int calls(const std::string& name) const {
        const std::vector<json> all = readLog("call");
        return int(std::count_if(all.begin(), all.end(), [&](const json& c) { return c["call"] == name; }));
    }
    // The types of each frame's layers, such as "projection quad".
    std::vector<std::string> layers() const {
        std::vector<std::string> all;
        for (const json& frame : readLog("frame")) {
            std::string types;
            for (const json& layer : frame["layers"])
                types += (types.empty() ? "" : " ") + layer["type"].get<std::string>();
            all.push_back(types);
        }
        return all;
    }

    const patient::Package package_ = thinPhantom();
    const patient::Patient patient_{package_};
    const patient::PlannedPath path_ = test::ductPath();
    test::TempFolder folder_;
    PictureSettings settings_;
    FrameState seen_ = outside();
    std::optional<FrameLoop> loop_;
    bool running_ = true;
};

// HZ-RECORD-12
TEST_F(HeadsetTest, ALostSessionIsRecreatedAndTheAttemptContinues) {
    play(R"({"events": [{"frame": 6, "session_loss": {"lost_after_s": 0}}]})");
    show(5);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    play("{}");
    const std::uint64_t before = loop_->totals().rendered;
    EXPECT_GT(before, 0u);
    bool was_absent = false;
    for (int i = 0; i < 10; ++i) {
        show(1);
        EXPECT_TRUE(running_);
        was_absent |= loop_->attention() == Attention::absent;
    }
    EXPECT_TRUE(was_absent);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    EXPECT_EQ(loop_->totals().headsets_found_again, 1u);
    EXPECT_GT(loop_->totals().rendered, before);
    EXPECT_EQ(loop_->totals().validation_messages, 0u);
    loop_.reset();
    EXPECT_EQ(calls("xrCreateInstance"), 2);
    EXPECT_EQ(calls("xrDestroyInstance"), 2);
}

TEST_F(HeadsetTest, AfterInstanceLossItRetriesUntilTheRuntimeIsBack) {
    play(R"({"events": [{"frame": 6, "instance_loss": {"lost_after_s": 0}}]})");
    show(5);
    setenv("XR_RUNTIME_JSON", "/nowhere/runtime.json", 1);
    testing::internal::CaptureStderr();
    show(8);
    const std::string away = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(running_);
    EXPECT_EQ(loop_->attention(), Attention::absent);
    EXPECT_NE(away.find("the headset was lost"), std::string::npos) << away;
    EXPECT_NE(away.find("still no headset"), std::string::npos) << away;
    EXPECT_EQ(std::count(away.begin(), away.end(), '\n'), 2) << "said once, not with every look: " << away;
    setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
    play("{}");
    show(8);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    EXPECT_EQ(loop_->totals().headsets_found_again, 1u);
}

TEST_F(HeadsetTest, LosingFocusShowsThatTheAttemptIsPaused) {
    play(R"({"events": [{"frame": 8, "session": "visible"}, {"frame": 14, "session": "focused"}]})", 320);
    show(6);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    show(6, "paused");
    EXPECT_EQ(loop_->attention(), Attention::away);
    show(6);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    const std::vector<std::string> shown = layers();
    EXPECT_EQ(shown[5], "projection");
    EXPECT_EQ(shown[10], "projection quad");
    EXPECT_EQ(shown.back(), "projection");
    // The panel below the centre of view is dark, with amber and light letters.
    const test::Picture picture = test::loadPicture(folder_ / "paused_left.png");
    ASSERT_EQ(picture.width, 320);
    int amber = 0, light = 0, dark = 0;
    for (int y = 100; y < 260; ++y)
        for (int x = 40; x < 280; ++x) {
            const std::uint8_t* rgb = &picture.rgb[std::size_t(3 * (y * picture.width + x))];
            amber += rgb[0] > 180 && rgb[2] < 140;
            light += rgb[0] > 180 && rgb[2] > 180;
            dark += rgb[0] < 30 && rgb[2] < 40;
        }
    EXPECT_GT(amber, 100);
    EXPECT_GT(light, 100);
    EXPECT_GT(dark, 5000);
    EXPECT_EQ(loop_->totals().validation_messages, 0u);
}

// HZ-FORCE-12
TEST_F(HeadsetTest, ARemovedHeadsetCountsAsAbsentUser) {
    play(R"({"events": [{"frame": 6, "user_presence": false}, {"frame": 10, "user_presence": true}]})");
    show(5);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    show(4);
    EXPECT_EQ(loop_->attention(), Attention::away);
    show(4);
    EXPECT_EQ(loop_->attention(), Attention::focused);
}

TEST_F(HeadsetTest, AFaultIsShownInTheHeadset) {
    show(5);
    seen_.tick.stage = haptics::ForceStage::off;
    seen_.tick.faults = haptics::kFaultOverSpeed;
    show(2);
    EXPECT_EQ(layers().back(), "projection quad");
    seen_.tick.stage = haptics::ForceStage::on;
    show(2);
    EXPECT_EQ(layers().back(), "projection");
}

TEST_F(HeadsetTest, AnInvisibleFrameIsSubmittedEmptyAndNotRendered) {
    play(R"({"events": [{"frame": 7, "frames": {"not_rendered": true, "count": 3}}]})");
    show(12);
    const FrameTotals totals = loop_->totals();
    const std::vector<std::string> shown = layers();
    EXPECT_EQ(shown.size(), totals.frames);
    EXPECT_EQ(std::uint64_t(std::count(shown.begin(), shown.end(), "projection")), totals.rendered);
    EXPECT_EQ(shown[7], "");
    EXPECT_EQ(shown[10], "projection");
}

TEST_F(HeadsetTest, TheRuntimeCanEndTheLoop) {
    play(R"({"exit_after_frames": 6})");
    for (int i = 0; i < 20 && running_; ++i)
        show(1);
    EXPECT_FALSE(running_);
}

TEST_F(HeadsetTest, DepthAndLateViewsAreSubmitted) {
    setenv("XRMOCK_REPORT", (folder_ / "report").c_str(), 1);
    play(R"({"head": [{"t_s": 0, "position": [0, 1.6, 0]}, {"t_s": 5, "position": [0.5, 1.5, 0]}],
             "assertions": [{"every_frame_has": "depth"},
                            {"depth_range": {"near_m": [0.04, 0.06], "far_m": [19, 21]}},
                            {"views_within": {"position_m": 1e-5, "angle_rad": 1e-5}},
                            {"refusals_at_most": 0}, {"frames_at_least": 10}]})");
    show(12);
    loop_.reset();
    unsetenv("XRMOCK_REPORT");
    std::ifstream report(folder_ / "report.xml");
    const std::string text{std::istreambuf_iterator<char>(report), {}};
    EXPECT_NE(text.find("tests=\"5\""), std::string::npos) << text;
    EXPECT_NE(text.find("failures=\"0\""), std::string::npos) << text;
}

// With a registered device, the room's origin follows the device. Recentring moves the origin of the
// runtime's poses. The picture must stay in place, and the force is off until the user confirms.
// HZ-FORCE-13
TEST_F(HeadsetTest, AfterRecentringTheSceneStaysInPlaceAndAsksForConfirmation) {
    Registration device;
    device.key = {"bridge", "bridge", "stage", ""};
    device.stage_from_device = {Quat{std::cos(0.15), 0.0, std::sin(0.15), 0.0}, {0.05, 1.05, -0.55}};
    settings_.colocation = {device, levelPatientFromDevice(device, stageFromPatient(patient_, fieldOf(path_)),
                                                           0.5 * (path_.entry_m + path_.target_m))};
    play(R"({"events": [{"frame": 14, "recenter": {"space": "stage", "delay_s": 0,
             "pose": {"position": [0.6, 0, 0.3], "orientation": [0, 0.38268343, 0, 0.92387953]}}}]})",
         320);
    show(6);
    EXPECT_EQ(loop_->attention(), Attention::absent) << "a stage is no proof of being the registered one";
    EXPECT_EQ(layers().back(), "projection quad");
    ++seen_.rearm_acts;
    show(2);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    show(1, "before");
    testing::internal::CaptureStderr();
    show(8, "after");
    EXPECT_NE(testing::internal::GetCapturedStderr().find("room has moved"), std::string::npos);
    EXPECT_EQ(loop_->attention(), Attention::absent) << "no force";
    EXPECT_EQ(layers().back(), "projection quad");
    show(10);
    EXPECT_EQ(loop_->attention(), Attention::absent) << "for as long as nobody asks for it";
    ++seen_.rearm_acts;
    show(2);
    EXPECT_EQ(loop_->attention(), Attention::focused);
    EXPECT_EQ(layers().back(), "projection");
    show(1, "confirmed");
    const test::Picture before = test::loadPicture(folder_ / "before_left.png"),
                        now = test::loadPicture(folder_ / "confirmed_left.png");
    ASSERT_EQ(before.rgb.size(), now.rgb.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < now.rgb.size(); ++i)
        squares += std::pow(double(now.rgb[i]) - before.rgb[i], 2);
    EXPECT_GT(10.0 * std::log10(255.0 * 255.0 * double(now.rgb.size()) / squares), 40.0);
}

// With passthrough, the patient lies in the real room. Pixels without an object must be transparent.
TEST_F(HeadsetTest, PassthroughPixelsAreTransparent) {
    settings_.config.passthrough = true;
    const std::string aside =
        R"("head": [{"t_s": 0, "position": [0, 1.6, 0.5], "orientation": [0.17, 0, 0, 0.985]}])";
    for (const bool offered : {true, false}) {
        SCOPED_TRACE(offered);
        play("{" + aside + (offered ? R"(, "offers": {"blend_modes": ["opaque", "alpha_blend"]}})" : "}"),
             200);
        loop_.reset();
        show(8, "above");
        const test::Picture picture = test::loadPicture(folder_ / "above_left.png");
        int nothing = 0;
        for (std::size_t i = 0; i < picture.rgb.size(); i += 3)
            nothing += picture.rgb[i] + picture.rgb[i + 1] + picture.rgb[i + 2] == 0;
        if (offered)
            EXPECT_GT(nothing, 10000);
        else
            EXPECT_LT(nothing, 100) << "the drawn room";
        EXPECT_EQ(loop_->totals().validation_messages, 0u);
    }
}

// The screen is a quad layer below the rendered image. The image is transparent at the screen but keeps its
// colours, so that it is complete without the quad layer.
TEST_F(HeadsetTest, AScreenIsAQuadLayerBeneathTheProjectionLayer) {
    render::Gpu gpu{render::GpuSettings{}};
    render::Renderer renderer(gpu, {}, settings_.assets);
    renderer.setPatient(patient_);
    render::RenderScene scene;
    scene.stage_from_patient = stageFromPatient(patient_, fieldOf(path_));
    scene.room = render::wholeRoom();
    const render::ScreenPlace glass = renderer.screenPlaces(scene)[2];
    EXPECT_NEAR(glass.width_m / glass.height_m, double(BreathMonitor::kWidth) / BreathMonitor::kHeight, 0.01);
    const Pose eye =
        stageFromEyes(glass.stage_from_screen * Vec3(0.0, 0.0, 0.6), glass.stage_from_screen.position_m);
    const std::vector<std::uint8_t> red(4 * 64 * 64, 200);
    scene.monitor_screen = {64, 64, red.data(), 1};
    const std::array<render::View, 2> views{render::View{eye}, render::View{eye}};
    const render::Image opaque = renderer.drawToImages(scene, views, 200, 200)[0];
    scene.monitor_screen.beneath = true;
    const render::Image clear = renderer.drawToImages(scene, views, 200, 200)[0];
    int through = 0;
    for (std::size_t i = 0; i < opaque.rgba.size(); i += 4) {
        EXPECT_TRUE(std::equal(&opaque.rgba[i], &opaque.rgba[i] + 3, &clear.rgba[i]));
        EXPECT_EQ(opaque.rgba[i + 3], 255);
        through += clear.rgba[i + 3] == 0;
    }
    const double share = glass.width_m * glass.height_m / std::pow(2.0 * 0.6 * std::tan(0.7), 2);
    EXPECT_NEAR(through, share * 200 * 200, 0.1 * share * 200 * 200);

    play(json{{"head", headKeys(eye)}}.dump(), 320);
    show(8, "monitor");
    EXPECT_EQ(layers().back(), "quad projection");
    const test::Picture seen = test::loadPicture(folder_ / "monitor_left.png");
    int amber = 0;
    for (std::size_t i = 0; i < seen.rgb.size(); i += 3)
        amber += seen.rgb[i] > 200 && seen.rgb[i + 2] < 120;
    EXPECT_GT(amber, 20) << "what the monitor writes";
}

}  // namespace
}  // namespace stylet::trainer
