// Assertions of a scenario, and the report as text and as JUnit.
#include <fstream>
#include <iterator>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

class Report : public MockTest {
  protected:
    void assertions(const std::string& list, const std::string& more = "") {
        setScript("{\"version\": 2, " + more + "\"assertions\": [" + list + "]}");
        setVariable("XRMOCK_REPORT", file("report").string());
    }
    // Destroys the instance and returns the report's text.
    std::string finish() {
        vkDeviceWaitIdle(vk_device_);
        testing::internal::CaptureStderr();
        EXPECT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
        stderr_ = testing::internal::GetCapturedStderr();
        instance_ = XR_NULL_HANDLE;
        // The reports of a process are numbered, so the file's name is not known.
        for (const auto& entry : std::filesystem::directory_iterator(file(""))) {
            if (entry.path().extension() == ".xml") xml_ = read(entry.path());
            if (entry.path().extension() == ".txt") text_ = read(entry.path());
        }
        return text_;
    }
    static std::string read(const std::filesystem::path& path) {
        std::ifstream in(path);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    std::string stderr_, xml_, text_;
};

TEST_F(Report, MetAssertionsAreOk) {
    assertions(R"({"frames_at_least": 5}, {"refusals_at_most": 0}, {"discarded_at_most": 0},
        {"missed_at_most": 0}, {"every_frame_has": "projection", "frames": [4, 100]},
        {"views_within": {"position_m": 1e-6, "angle_rad": 1e-5}}, {"format": 43},
        {"states": ["ready", "synchronized", "visible", "focused"]})");
    startFocused();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    for (int i = 0; i < 3; ++i)
        projectionFrame(swapchain);
    const std::string text = finish();
    EXPECT_NE(text.find("mock test: 8 assertions, 0 failed"), std::string::npos) << text;
    EXPECT_EQ(text.find("FAILED"), std::string::npos) << text;
    EXPECT_EQ(stderr_, "");
    EXPECT_NE(xml_.find("<testsuites name=\"xrmock\" tests=\"8\" failures=\"0\" errors=\"0\""),
              std::string::npos)
        << xml_;
}

TEST_F(Report, EveryFailedAssertionGivesItsReason) {
    assertions(R"({"frames_at_least": 500}, {"refusals_at_most": 0}, {"discarded_at_most": 0},
        {"missed_at_most": 0}, {"every_frame_has": "depth"},
        {"name": "eyes <as> located", "views_within": {"position_m": 0.01, "angle_rad": 0.01}},
        {"format": 50}, {"depth_range": {"near_m": [0, 1], "far_m": [1, 100]}},
        {"states": ["focused", "stopping"]}, {"haptic_pulse": {"hand": "left", "from_s": 0, "to_s": 9}},
        {"pixel": {"frame": 99, "eye": "left", "at": [0.5, 0.5], "rgb": [0, 0, 0]}})",
               R"("events": [{"frame": 5, "frames": {"late": 2, "discarded": true}}], )");
    startFocused();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    EXPECT_EQ(endFrame(1), XR_ERROR_CALL_ORDER_INVALID);
    projectionFrame(swapchain, 0.5F);
    XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, 0};
    EXPECT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    const std::string text = finish();
    for (const char* line :
         {"11 assertions, 11 failed", "frames_at_least (1): 4 frames instead of at least 500",
          "refusals_at_most (2): 1 instead of at most 0; the first: xrEndFrame: "
          "XR_ERROR_CALL_ORDER_INVALID: no frame was begun",
          "discarded_at_most (3): 1 instead", "missed_at_most (4): 2 instead",
          "every_frame_has (5): frame 3: there is no such layer",
          "eyes <as> located: frame 4: left eye: 0.5 m and 0 rad from the located view",
          "format (7): frame 4: left eye: format 43", "depth_range (8): frame 4: left eye: there is no depth",
          "states (9): stopping was not reached", "haptic_pulse (10): 0 pulses",
          "pixel (11): no frame to look at was submitted"}) {
        EXPECT_NE(text.find(line), std::string::npos) << line << "\n\n" << text;
    }
    EXPECT_NE(stderr_.find("xrmock: FAILED format (7)"), std::string::npos);
    EXPECT_NE(xml_.find("name=\"eyes &lt;as&gt; located\""), std::string::npos) << xml_;
    EXPECT_NE(xml_.find("failures=\"11\""), std::string::npos);
}

// A frame may be waited for before the previous one ends. The report uses the shouldRender value that the
// frame had then, not the session's current state.
TEST_F(Report, FramesThatShouldNotRenderAreNotChecked) {
    assertions(R"({"every_frame_has": "quad"})");
    startRunning();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    cycle(swapchain.handle);
    const XrCompositionLayerQuad quad = quadLayer(stage_, swapchain, kAhead, {0.1F, 0.1F});
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    for (int i = 0; i < 6; ++i) {
        auto next = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
        ASSERT_EQ(beginFrame(), XR_SUCCESS);
        ASSERT_EQ(waitFrame(&next), XR_SUCCESS);
        std::vector<const XrCompositionLayerBaseHeader*> layers;
        if (state.shouldRender) layers.push_back(header(quad));
        ASSERT_EQ(endFrame(state.predictedDisplayTime, layers), XR_SUCCESS);
        state = next;
    }
    EXPECT_TRUE(state.shouldRender);
    const std::string text = finish();
    EXPECT_NE(text.find("ok      every_frame_has (1)"), std::string::npos) << text;
}

TEST_F(Report, PixelsOfAComposedEyeAreChecked) {
    // The quad's image was never drawn to. Outside the quad the eye sees black.
    assertions(R"({"pixel": {"frame": 4, "eye": "right", "at": [0.01, 0.01], "rgb": [0, 0, 0]}},
                  {"pixel": {"frame": 4, "eye": "right", "at": [0.01, 0.01], "rgb": [9, 0, 0], "tolerance": 8}})");
    startFocused();
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    cycle(swapchain.handle);
    const XrCompositionLayerQuad quad = quadLayer(stage_, swapchain, kAhead, {0.1F, 0.1F});
    frame({header(quad)});
    const std::string text = finish();
    EXPECT_NE(text.find("ok      pixel (1)"), std::string::npos) << text;
    EXPECT_NE(text.find("FAILED  pixel (2): frame 4: the pixel is 0, 0, 0"), std::string::npos) << text;
}

TEST_F(Report, AReportThatCannotBeWrittenIsAnError) {
    assertions(R"({"frames_at_least": 0})");
    setVariable("XRMOCK_REPORT", file("nowhere/report").string());
    ASSERT_EQ(tryInstance(), XR_SUCCESS);
    testing::internal::CaptureStderr();
    destroyInstance();
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("nowhere/report"), std::string::npos) << said;
    EXPECT_NE(said.find("cannot be written"), std::string::npos) << said;
}

TEST_F(Report, BadAssertionsAreRefused) {
    for (const char* list :
         {R"({})", R"({"frames_at_least": -1})", R"({"format": 1, "states": []})",
          R"({"states": ["asleep"]})", R"({"pixel": {"frame": 1}})", R"({"frames": [1, 2]})",
          R"({"states": []})", R"({"format": 43, "frames": [9, 2]})", R"({"format": 43, "frames": [1.5, 2]})",
          R"({"frames_at_least": 1, "frames": [1, 2]})", R"({"haptic_pulse": {"from_s": 2, "to_s": 1}})"}) {
        assertions(list);
        testing::internal::CaptureStderr();
        EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE) << list;
        EXPECT_NE(testing::internal::GetCapturedStderr().find(": assertions[0]"), std::string::npos) << list;
    }
}

}  // namespace
}  // namespace mock_test
