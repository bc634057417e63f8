// Tests the session with the real loader and the mock runtime: states, views, pictures, controllers, and the
// end of the session.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <openxr/openxr.h>

#include "render_loop.h"

namespace stylet::xr {
namespace {

namespace fs = std::filesystem;

bool layerInstalled(const std::string& name) {
    std::uint32_t count = 0;
    xrEnumerateApiLayerProperties(0, &count, nullptr);
    XrApiLayerProperties blank{};
    blank.type = XR_TYPE_API_LAYER_PROPERTIES;
    std::vector<XrApiLayerProperties> layers(count, blank);
    xrEnumerateApiLayerProperties(count, &count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [&](const auto& l) { return name == l.layerName; });
}

TEST_F(SessionTest, AllStatesAreVisitedInOrder) {
    RenderLoop loop;
    EXPECT_EQ(loop.session.runtimeName(), "XR Mock");
    std::vector<SessionPhase> seen;
    for (int i = 0; i < 20; ++i) {
        const SessionPhase phase = loop.session.poll();
        if (seen.empty() || seen.back() != phase) seen.push_back(phase);
        if (!loop.session.running()) continue;
        const Frame frame = loop.frame();
        EXPECT_EQ(frame.should_render, phase == SessionPhase::visible || phase == SessionPhase::focused);
    }
    EXPECT_EQ(seen.back(), SessionPhase::focused);
    EXPECT_THAT(seen, testing::IsSupersetOf(
                          {SessionPhase::ready, SessionPhase::synchronized, SessionPhase::visible}));
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
}

TEST_F(SessionTest, ViewsMatchTheScenarioAtTheDisplayTime) {
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    EXPECT_EQ(loop.session.width(), 64u);
    EXPECT_EQ(loop.session.height(), 48u);
    std::int64_t before_ns = 0;
    for (int i = 0; i < 20; ++i) {
        const Frame frame = loop.frame();
        ASSERT_TRUE(frame.should_render);
        EXPECT_GT(frame.predicted_display_time_ns, before_ns);
        before_ns = frame.predicted_display_time_ns;
        const double head_x = 0.1 * double(frame.predicted_display_time_ns) * 1e-9;
        const EyeView &left = frame.views[0], &right = frame.views[1];
        EXPECT_NEAR(left.stage_from_eye.position_m.x, head_x - 0.03, 1e-6);
        EXPECT_NEAR(right.stage_from_eye.position_m.x, head_x + 0.03, 1e-6);
        EXPECT_NEAR(left.stage_from_eye.position_m.y, 1.5, 1e-6);
        EXPECT_NEAR(left.stage_from_eye.rotation.w, 1.0, 1e-6);
        EXPECT_FLOAT_EQ(left.angle_left, -0.9f);
        EXPECT_FLOAT_EQ(left.angle_right, 0.7f);
        EXPECT_FLOAT_EQ(right.angle_right, 0.9f);
        EXPECT_FLOAT_EQ(right.angle_up, 0.8f);
        EXPECT_FLOAT_EQ(right.angle_down, -0.75f);
    }
}

TEST_F(SessionTest, ACaptureContainsBothEyes) {
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame("skin");
    loop.frame();
    loop.frame("duct");
    for (const char* name : {"skin_left.png", "skin_right.png", "duct_left.png", "duct_right.png"})
        EXPECT_TRUE(fs::exists(folder_ / name)) << name;
}

TEST_F(SessionTest, TheControllerIsRead) {
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame();
    EXPECT_FALSE(loop.session.hand(0).active);
    const Hand early = loop.session.hand(1);
    ASSERT_TRUE(early.active);
    ASSERT_TRUE(early.stage_from_grip.has_value());
    EXPECT_NEAR(early.stage_from_grip->position_m.x, 0.25, 1e-6);
    EXPECT_NEAR(early.stage_from_grip->position_m.z, -0.5, 1e-6);
    EXPECT_FALSE(early.select);
    loop.session.pulse(1, 0.5f, 20'000'000);
    Frame frame;
    while (frame.predicted_display_time_ns < 1'150'000'000)
        frame = loop.frame();
    EXPECT_TRUE(loop.session.hand(1).select);
    EXPECT_FALSE(loop.session.hand(1).menu);
}

TEST_F(SessionTest, RequestedExitEndsInExiting) {
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.session.requestExit();
    EXPECT_TRUE(loop.runUntil(SessionPhase::exiting));
    EXPECT_FALSE(loop.session.running());
}

TEST_F(SessionTest, TheRuntimeCanPauseAndEndTheSession) {
    useScenario(R"("session": [{"t_s": 0, "state": "focused"}, {"t_s": 1.2, "state": "synchronized"},
        {"t_s": 1.4, "state": "stopped"}, {"t_s": 1.6, "state": "exiting"}])");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    ASSERT_TRUE(loop.runUntil(SessionPhase::synchronized, 60));
    const Frame hidden = loop.frame();
    EXPECT_FALSE(hidden.should_render);
    EXPECT_EQ(hidden.image, VkImage(VK_NULL_HANDLE));
    ASSERT_TRUE(loop.runUntil(SessionPhase::idle, 60));
    EXPECT_FALSE(loop.session.running());
}

TEST_F(SessionTest, TheValidationLayerReportsNothing) {
    if (!layerInstalled("XR_APILAYER_LUNARG_core_validation"))
        GTEST_SKIP() << "XR_APILAYER_LUNARG_core_validation is not installed";
    const fs::path report = folder_ / "validation.txt";
    setenv("XR_CORE_VALIDATION_FILE_NAME", report.c_str(), 1);
    setenv("XR_ENABLE_API_LAYERS", "XR_APILAYER_LUNARG_core_validation", 1);
    setenv("XR_CORE_VALIDATION_EXPORT_TYPE", "text", 1);
    useScenario(
        R"("controllers": {"right": {}}, "hands": {"left": {"poses": [{"t_s": 0, "position": [0, 1, 0]}]}},
        "events": [{"frame": 8, "recenter": {"space": "stage"}}, {"frame": 9, "visibility_mask": {}},
                   {"frame": 9, "user_presence": false}, {"frame": 10, "refresh_hz": 72},
                   {"frame": 11, "frames": {"discarded": true}}])");
    testing::internal::CaptureStderr();
    {
        RenderLoop loop;
        ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
        // No picture is captured, because Debian's layer (1.0.20) deadlocks in
        // xrSessionInsertDebugUtilsLabelEXT.
        loop.session.setDepthRange(0.05f, 50.0f);
        ShownPanel panel;
        panel.id = loop.session.addPanel(32, 16);
        panel.stage_from_panel.position_m = {0, 1.5, -1};
        panel.width_m = panel.height_m = 1.0;
        ShownPanel behind = panel;
        behind.behind = true;
        loop.panels = {panel, behind};
        for (int i = 0; i < 16; ++i) {
            const VkImage image = loop.session.acquirePanel(panel.id);
            loop.painter->paintPanel(image, 32, 16, {0, 1, 0, 1});
            loop.session.releasePanel(panel.id);
            loop.run(1);
        }
        EXPECT_FALSE(loop.session.hiddenArea(0).indices.empty());
        EXPECT_TRUE(loop.session.gripAt(1, 0).has_value());
        EXPECT_TRUE(loop.session.hand(0).bare);
        EXPECT_EQ(loop.spaces.size(), 1u);
        EXPECT_NE(loop.session.facts().profiles[1], "");
        loop.session.pulse(1, 0.5f, 20'000'000);
        loop.session.requestExit();
        EXPECT_TRUE(loop.runUntil(SessionPhase::exiting));
    }
    unsetenv("XR_ENABLE_API_LAYERS");
    EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("Core Validation"))
        << "the layer was not there";
    std::ifstream in(report);  // created with the first message
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "");
}

TEST_F(SessionTest, ASecondSessionWorksInTheSameProcess) {
    for (int round = 0; round < 2; ++round) {
        std::chrono::steady_clock::time_point left_at;
        {
            RenderLoop loop;
            ASSERT_TRUE(loop.runUntil(SessionPhase::focused)) << "round " << round;
            EXPECT_TRUE(loop.frame().should_render);
            left_at = std::chrono::steady_clock::now();
        }
        const auto took = std::chrono::steady_clock::now() - left_at;
        RecordProperty("left_after_ms", int(took / std::chrono::milliseconds(1)));
    }
    // Each session was ended and destroyed, not abandoned after a timeout.
    EXPECT_EQ(calls("xrEndSession").size(), 2u);
    EXPECT_EQ(calls("xrDestroySession").size(), 2u);
    EXPECT_EQ(calls("xrDestroyInstance").size(), 2u);
}

}  // namespace
}  // namespace stylet::xr
