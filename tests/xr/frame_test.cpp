// The contents of a submitted frame: views, depth, panels, and blending.
#include <algorithm>
#include <cmath>
#include <limits>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "render_loop.h"
#include "tests/support/picture.h"

namespace stylet::xr {
namespace {

constexpr int kBlendAlpha = 2, kStraightAlpha = 4;  // XrCompositionLayerFlagBits

class LayersTest : public SessionTest {
  protected:
    // The colour in the centre of an eye's captured picture.
    std::array<int, 3> middlePixel(const std::string& picture) const {
        const test::Picture loaded = test::loadPicture(folder_ / (picture + ".png"));
        if (loaded.rgb.empty()) return {-1, -1, -1};
        const std::uint8_t* at = loaded.at(loaded.width / 2, loaded.height / 2);
        return {at[0], at[1], at[2]};
    }
    // Sends a message to the mock runtime's control socket. Returns after it was processed.
    void sendRequest(RenderLoop& loop, const std::string& message) const {
        const int wire = socket(AF_UNIX, SOCK_STREAM, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        (folder_ / "control").string().copy(address.sun_path, sizeof address.sun_path - 1);
        ASSERT_EQ(connect(wire, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        const std::string line = message + "\n";
        ASSERT_EQ(write(wire, line.data(), line.size()), ssize_t(line.size()));
        char reply[256] = {};
        for (int i = 0; i < 60'000 && recv(wire, reply, sizeof reply - 1, MSG_DONTWAIT) < 0; ++i) {
            usleep(1000);
            loop.poll();
        }
        close(wire);
        EXPECT_THAT(std::string(reply), testing::HasSubstr("true"));
    }
};

RenderLoop& runUntilFocused(RenderLoop& loop) {
    EXPECT_TRUE(loop.runUntil(SessionPhase::focused));
    return loop;
}

int makePanel(RenderLoop& loop, std::uint32_t width, std::uint32_t height,
              const std::array<float, 4>& colour) {
    const int id = loop.session.addPanel(width, height);
    const VkImage image = loop.session.acquirePanel(id);
    EXPECT_NE(image, VkImage(VK_NULL_HANDLE));
    loop.painter->paintPanel(image, width, height, colour);
    loop.session.releasePanel(id);
    return id;
}

// The head jumps while a frame is prepared, so that the early and the late views differ clearly.
// HZ-TEACH-04
TEST_F(LayersTest, LateUpdatedViewsAreSubmitted) {
    setVariable("XRMOCK_CONTROL", folder_ / "control");
    Frame early, late;
    {
        RenderLoop loop;
        runUntilFocused(loop);
        early = late = loop.session.beginFrame();
        EXPECT_TRUE(loop.session.lateUpdate(late));
        EXPECT_EQ(late.views[0].stage_from_eye.position_m, early.views[0].stage_from_eye.position_m);
        sendRequest(loop, R"({"apply": {"head": [{"position": [3, 1.5, 0]}]}})");
        EXPECT_TRUE(loop.session.lateUpdate(late));
        loop.painter->paint(late.image, {});
        loop.session.endFrame(late);
    }
    EXPECT_EQ(late.predicted_display_time_ns, early.predicted_display_time_ns);
    EXPECT_EQ(late.image, early.image);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const double x = late.views[eye].stage_from_eye.position_m.x;
        EXPECT_NEAR(x, eye == 0 ? 2.97 : 3.03, 1e-6);
        EXPECT_EQ(double(frames().back()["layers"][0]["views"][eye]["pose"][0]), x) << "to the bit";
    }
    EXPECT_EQ(frames().back()["layers"][0]["flags"], 0) << "an opaque picture";
}

TEST_F(LayersTest, DepthIsSubmittedOnceTheDepthRangeIsSet) {
    {
        RenderLoop loop;
        runUntilFocused(loop);
        EXPECT_EQ(loop.frame().depth_image, VkImage(VK_NULL_HANDLE));
        loop.session.setDepthRange(0.05f, std::numeric_limits<float>::infinity());
        const Frame frame = loop.frame();
        EXPECT_NE(frame.depth_image, VkImage(VK_NULL_HANDLE));
        loop.session.setDepthRange(0.1f, 50.0f);
        loop.frame();
    }
    const auto all = frames();
    ASSERT_GE(all.size(), 3u);
    EXPECT_FALSE(all[all.size() - 3]["layers"][0]["views"][0].contains("depth"));
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const auto& depth = all.back()["layers"][0]["views"][eye]["depth"];
        EXPECT_EQ(depth["range"][0], 0.0);
        EXPECT_EQ(depth["range"][1], 1.0);
        EXPECT_NEAR(double(depth["near_z_m"]), 50.0, 1e-6) << "reversed: 0 is far";
        EXPECT_NEAR(double(depth["far_z_m"]), 0.1, 1e-6);
        EXPECT_EQ(depth["image"]["array_index"], eye);
        EXPECT_EQ(depth["image"]["format"], int(VK_FORMAT_D32_SFLOAT));
    }
}

TEST_F(LayersTest, WithoutExtensionOrFormatDepthIsOmitted) {
    setVariable("XRMOCK_WITHHOLD", "XR_KHR_composition_layer_depth");
    {
        RenderLoop loop;
        loop.session.setDepthRange(0.1f, 50.0f);
        EXPECT_EQ(runUntilFocused(loop).frame().depth_image, VkImage(VK_NULL_HANDLE));
    }
    setVariable("XRMOCK_WITHHOLD", "");
    useScenario(R"("offers": {"formats": [50, 129]})");  // B8G8R8A8_SRGB, D24_UNORM_S8_UINT
    RenderLoop loop;
    EXPECT_EQ(loop.session.colourFormat(), VK_FORMAT_B8G8R8A8_SRGB);
    loop.session.setDepthRange(0.1f, 50.0f);
    EXPECT_EQ(runUntilFocused(loop).frame().depth_image, VkImage(VK_NULL_HANDLE));
    EXPECT_THAT(loop.session.notes(), testing::Contains(testing::HasSubstr("depth")));
}

TEST_F(LayersTest, ARefusedSwapchainDisablesOnlyItself) {
    useScenario(R"("events": [{"frame": 2, "refuse": {"call": "xrCreateSwapchain", "times": 2,
        "result": "XR_ERROR_OUT_OF_MEMORY"}}])");
    RenderLoop loop;
    runUntilFocused(loop);
    loop.session.setDepthRange(0.1f, 10.0f);
    ShownPanel panel;
    panel.id = loop.session.addPanel(64, 64);
    EXPECT_EQ(panel.id, -1);
    EXPECT_EQ(loop.session.acquirePanel(panel.id), VkImage(VK_NULL_HANDLE));
    loop.session.releasePanel(panel.id);
    loop.panels = {panel};
    EXPECT_EQ(loop.session.notes().size(), 2u);
    const Frame frame = loop.frame();
    EXPECT_TRUE(frame.should_render);
    EXPECT_EQ(frame.depth_image, VkImage(VK_NULL_HANDLE));
    EXPECT_EQ(loop.session.addPanel(64, 64), 0);
}

TEST_F(LayersTest, WithoutHeadTrackingNothingIsRendered) {
    useScenario(R"("events": [{"frame": 8, "head_tracked": false}, {"frame": 10, "head_tracked": true}])");
    RenderLoop loop;
    runUntilFocused(loop);
    std::vector<bool> drawn;
    for (int i = 0; i < 8; ++i)
        drawn.push_back(loop.frame().should_render);
    EXPECT_EQ(std::count(drawn.begin(), drawn.end(), false), 2);
    EXPECT_TRUE(drawn.back());
}

TEST_F(LayersTest, APanelIsAQuadLayerWithStraightAlpha) {
    {
        RenderLoop loop;
        runUntilFocused(loop);
        ShownPanel panel;
        panel.id = makePanel(loop, 32, 16, {0, 1, 0, 0.5f});  // half transparent green
        panel.stage_from_panel.position_m = {0.1, 1.5, -1.0};
        panel.width_m = 4.0;
        panel.height_m = 2.0;
        const int never_drawn = loop.session.addPanel(8, 8);
        loop.panels = {panel, {.id = never_drawn, .stage_from_panel = {}, .width_m = 1, .height_m = 1}};
        loop.frame("room");
        loop.panels[0].head_locked = true;
        loop.panels[0].stage_from_panel.position_m = {0, 0, -2};
        loop.frame("head");
    }
    // Left eye: half red plus half green in linear light. Linear 0.5 is 188 in sRGB.
    const auto left = middlePixel("room_left");
    EXPECT_NEAR(left[0], 188, 1);
    EXPECT_NEAR(left[1], 188, 1);
    EXPECT_NEAR(left[2], 0, 1);
    EXPECT_EQ(middlePixel("head_left"), left);
    const auto all = frames();
    const auto& layers = all[all.size() - 2]["layers"];
    ASSERT_EQ(layers.size(), 2u) << "a panel without a picture is left out";
    EXPECT_EQ(layers[0]["type"], "projection");
    EXPECT_EQ(layers[1]["type"], "quad");
    EXPECT_EQ(layers[1]["flags"], kBlendAlpha | kStraightAlpha);
    EXPECT_NEAR(double(layers[1]["size_m"][0]), 4.0, 1e-6);
    EXPECT_NEAR(double(layers[1]["pose"][0]), 0.1, 1e-6);
    EXPECT_EQ(layers[1]["space"], layers[0]["space"]);
    EXPECT_NE(all.back()["layers"][1]["space"], layers[0]["space"]);
}

TEST_F(LayersTest, APanelBehindShowsThroughTransparentPixels) {
    {
        RenderLoop loop;
        runUntilFocused(loop);
        ShownPanel panel;
        panel.id = makePanel(loop, 8, 8, {0, 1, 0, 1});
        panel.stage_from_panel.position_m = {0.1, 1.5, -1.0};
        panel.width_m = panel.height_m = 4.0;
        panel.behind = true;
        for (const char* moment : {"opaque", "clear", "half"}) {
            const Frame frame = loop.session.beginFrame();
            const float alpha = moment[0] == 'o' ? 1.0f : (moment[0] == 'c' ? 0.0f : 0.5f);
            loop.painter->paint(frame.image, {{{alpha, 0, 0, alpha}, {alpha, 0, 0, alpha}}});
            loop.session.markCapture(moment);
            loop.session.endFrame(frame, std::span(&panel, 1));
        }
    }
    EXPECT_EQ(middlePixel("opaque_left"), (std::array{255, 0, 0}));
    EXPECT_EQ(middlePixel("clear_left"), (std::array{0, 255, 0}));
    const auto half = middlePixel("half_right");
    EXPECT_NEAR(half[0], 137, 1) << "over panels colours are straight: 0.5 * 0.5, in linear light";
    EXPECT_NEAR(half[1], 188, 1);
    const auto layers = frames().back()["layers"];
    ASSERT_EQ(layers.size(), 2u);
    EXPECT_EQ(layers[0]["type"], "quad");
    EXPECT_EQ(layers[1]["flags"], kBlendAlpha | kStraightAlpha);
}

TEST_F(LayersTest, TooManyPanelsDoNotDropTheProjectionLayer) {
    RenderLoop loop;
    runUntilFocused(loop);
    ShownPanel panel;
    panel.id = makePanel(loop, 8, 8, {1, 1, 1, 1});
    panel.width_m = panel.height_m = 0.1;
    loop.panels.assign(300, panel);
    loop.frame();
    for (ShownPanel& each : loop.panels)
        each.behind = true;
    loop.frame();
    EXPECT_EQ(loop.poll(), SessionPhase::focused);
}

TEST_F(LayersTest, PassthroughUsesTheEnvironmentBlendMode) {
    constexpr const char* kModes[] = {R"(["opaque"])", R"(["opaque", "alpha_blend"])",
                                      R"(["additive", "opaque"])", R"(["additive"])"};
    constexpr const char* kAsked[] = {"opaque", "alpha_blend", "additive", "additive"};
    constexpr const char* kUnasked[] = {"opaque", "opaque", "opaque", "additive"};
    for (std::size_t i = 0; i < 4; ++i) {
        useScenario(R"("offers": {"blend_modes": )" + std::string(kModes[i]) + "}");
        for (const bool passthrough : {true, false}) {
            RenderLoop loop({.passthrough = passthrough, .virtual_clock = true});
            EXPECT_EQ(loop.session.facts().blend_mode, passthrough ? kAsked[i] : kUnasked[i]);
            EXPECT_EQ(loop.session.notes().empty(), !(passthrough && i == 0));
            runUntilFocused(loop).frame();
        }
    }
    // The picture's alpha determines where the real room is visible.
    for (const auto& frame : frames())
        if (!frame["layers"].empty()) {
            EXPECT_EQ(frame["layers"][0]["flags"], frame["blend_mode"] == 1 ? 0 : kBlendAlpha);
        }
}

}  // namespace
}  // namespace stylet::xr
