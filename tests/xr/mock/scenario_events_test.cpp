// The effect of every scenario event on an application.
#include <cmath>
#include <cstring>
#include <fstream>

#include "tests/xr/mock/client/client.h"
#include "xr/mock/scenario/openxr_later.h"

namespace mock_test {
namespace {

class ScenarioEvents : public MockTest {
  protected:
    void SetUp() override {
        MockTest::SetUp();
        extensions_ = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME, XR_EXT_USER_PRESENCE_EXTENSION_NAME,
                       XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME};
    }
    // Starts a version 2 scenario with these events and reaches the focused state, after three frames.
    void focusWith(const std::string& events, const std::string& more = "") {
        setScript("{\"version\": 2, " + more + "\"events\": [" + events + "]}");
        startFocused();
    }
    template <class Event>
    std::optional<Event> next(XrStructureType type) {
        const auto buffer = poll(type);
        if (!buffer) return std::nullopt;
        Event event;
        std::memcpy(&event, &*buffer, sizeof event);
        return event;
    }
    XrResult locateResult(XrTime time) {
        auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
        return xrLocateSpace(stage_, stage_, time, &location);
    }
    XrResult pollResult() {
        auto event = makeStruct<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
        return xrPollEvent(instance_, &event);
    }
    // Runs frames up to this frame number and returns its state.
    XrFrameState frameNumber(int number) {
        for (; frames_ < number - 1; ++frames_)
            frame();
        ++frames_;
        return frame();
    }

  private:
    int frames_ = 3;  // number of frames that startFocused() has run
};

TEST_F(ScenarioEvents, FocusIsLostAndRegained) {
    focusWith(R"({"frame": 5, "session": "visible"}, {"frame": 7, "session": "focused"})");
    frameNumber(6);
    EXPECT_EQ(states(), std::vector{XR_SESSION_STATE_VISIBLE});
    frameNumber(8);
    EXPECT_EQ(states(), std::vector{XR_SESSION_STATE_FOCUSED});
}

TEST_F(ScenarioEvents, AnExitIsRequested) {
    focusWith(R"({"frame": 5, "session": "exiting"})");
    frameNumber(5);
    const std::vector expected{XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED,
                               XR_SESSION_STATE_STOPPING};
    EXPECT_EQ(states(), expected);
    EXPECT_EQ(xrEndSession(session_), XR_SUCCESS);
    const std::vector end{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_EXITING};
    EXPECT_EQ(states(), end);
}

TEST_F(ScenarioEvents, TheUserTakesTheHeadsetOff) {
    setScript(R"({"version": 2, "events": [{"frame": 4, "user_presence": false},
                                           {"frame": 5, "user_presence": true}]})");
    start();
    auto presence =
        makeStruct<XrSystemUserPresencePropertiesEXT>(XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT);
    auto properties = makeStruct<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    properties.next = &presence;
    ASSERT_EQ(xrGetSystemProperties(instance_, system_, &properties), XR_SUCCESS);
    EXPECT_TRUE(presence.supportsUserPresence);
    ASSERT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
    startRunning();
    const auto type = XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT;
    auto event = next<XrEventDataUserPresenceChangedEXT>(type);
    ASSERT_TRUE(event);  // sent to every session that begins
    EXPECT_EQ(event->session, session_);
    EXPECT_TRUE(event->isUserPresent);
    for (int i = 0; i < 3; ++i)
        frame();
    EXPECT_FALSE(next<XrEventDataUserPresenceChangedEXT>(type));
    frame();
    event = next<XrEventDataUserPresenceChangedEXT>(type);
    ASSERT_TRUE(event);
    EXPECT_FALSE(event->isUserPresent);
    frame();
    event = next<XrEventDataUserPresenceChangedEXT>(type);
    ASSERT_TRUE(event);
    EXPECT_TRUE(event->isUserPresent);
}

TEST_F(ScenarioEvents, LocalIsRecentredAtItsChangeTime) {
    focusWith(R"({"frame": 5, "recenter": {"delay_s": 0.1, "pose": {"position": [1, 1.6, 0],
                  "orientation": [0, 0.70710678, 0, 0.70710678]}}})");
    const XrSpace local = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    const XrFrameState at = frameNumber(5);
    const auto event =
        next<XrEventDataReferenceSpaceChangePending>(XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->session, session_);
    EXPECT_EQ(event->referenceSpaceType, XR_REFERENCE_SPACE_TYPE_LOCAL);
    // The event happens when xrWaitFrame is called, at the display time of the previous frame.
    EXPECT_EQ(event->changeTime, at.predictedDisplayTime - at.predictedDisplayPeriod + 100'000'000);
    EXPECT_TRUE(event->poseValid);
    EXPECT_FLOAT_EQ(event->poseInPreviousSpace.position.x, 1);
    EXPECT_NEAR(event->poseInPreviousSpace.orientation.y, std::sqrt(0.5), 1e-6);
    EXPECT_FLOAT_EQ(locate(local, stage_, event->changeTime - 1).pose.position.x, 0);
    EXPECT_FLOAT_EQ(locate(local, stage_, event->changeTime).pose.position.x, 1);
    EXPECT_NEAR(locate(local, stage_, event->changeTime).pose.orientation.y, std::sqrt(0.5), 1e-6);
}

TEST_F(ScenarioEvents, NothingMovesWhenASpaceIsRecentred) {
    focusWith(R"({"frame": 5, "recenter": {"delay_s": 0.1, "pose": {"position": [1, 1.6, 0]}}})");
    const XrSpace local = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    frameNumber(5);
    const auto event =
        next<XrEventDataReferenceSpaceChangePending>(XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
    ASSERT_TRUE(event);
    auto velocity = makeStruct<XrSpaceVelocity>(XR_TYPE_SPACE_VELOCITY);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    location.next = &velocity;
    ASSERT_EQ(xrLocateSpace(stage_, local, event->changeTime, &location), XR_SUCCESS);
    EXPECT_EQ(location.pose.position.x, -1);
    EXPECT_EQ(velocity.velocityFlags,
              XrSpaceVelocityFlags{XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT});
    EXPECT_EQ(velocity.linearVelocity.x, 0);
}

TEST_F(ScenarioEvents, StageIsRecentredBelowTheHeadWithoutAPose) {
    focusWith(R"({"frame": 4, "recenter": {"space": "stage", "pose_valid": false}})",
              R"("head": [{"t_s": 0, "position": [0, 1.6, 0]}, {"t_s": 10, "position": [10, 1.6, 0]}], )");
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    frameNumber(4);
    const auto event =
        next<XrEventDataReferenceSpaceChangePending>(XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->referenceSpaceType, XR_REFERENCE_SPACE_TYPE_STAGE);
    EXPECT_FALSE(event->poseValid);
    const auto head = locate(view, stage_, event->changeTime).pose.position;
    EXPECT_NEAR(head.x, 0, 1e-6);
    EXPECT_NEAR(head.y, 1.6, 1e-6);
}

TEST_F(ScenarioEvents, TheRefreshRateChanges) {
    setScript(R"({"version": 2, "headset": "simple", "events": [{"frame": 5, "refresh_hz": 60}]})");
    startFocused();
    EXPECT_EQ(frameNumber(4).predictedDisplayPeriod, 11'111'111);
    EXPECT_EQ(frameNumber(5).predictedDisplayPeriod, 16'666'667);
    const auto event =
        next<XrEventDataDisplayRefreshRateChangedFB>(XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->fromDisplayRefreshRate, 90);
    EXPECT_EQ(event->toDisplayRefreshRate, 60);
}

TEST_F(ScenarioEvents, RatesOfEventsAreOffered) {
    focusWith(R"({"frame": 400, "refresh_hz": 72})");
    const auto enumerate =
        load<PFN_xrEnumerateDisplayRefreshRatesFB>(instance_, "xrEnumerateDisplayRefreshRatesFB");
    std::array<float, 4> rates{};
    std::uint32_t count = 0;
    ASSERT_EQ(enumerate(session_, 4, &count, rates.data()), XR_SUCCESS);
    EXPECT_EQ(count, 2U);
    EXPECT_EQ(rates[0], 72);
    EXPECT_EQ(rates[1], 90);
}

TEST_F(ScenarioEvents, OnlyCallsOfAnInstanceCanBeRefused) {
    for (const char* call : {"xrCreateInstance", "xrGetInstanceProcAddr", "xrFly"}) {
        setScript(R"({"version": 2, "events": [{"t_s": 0, "refuse": {"call": ")" + std::string(call) +
                  R"(", "result": "XR_ERROR_RUNTIME_FAILURE"}}]})");
        testing::internal::CaptureStderr();
        EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE);
        EXPECT_NE(testing::internal::GetCapturedStderr().find("events[0].refuse.call: "), std::string::npos)
            << call;
    }
}

TEST_F(ScenarioEvents, TheApplicationRequestsARefreshRate) {
    setScript(R"({"version": 2, "headset": "simple"})");
    startFocused();
    const auto enumerate =
        load<PFN_xrEnumerateDisplayRefreshRatesFB>(instance_, "xrEnumerateDisplayRefreshRatesFB");
    const auto get = load<PFN_xrGetDisplayRefreshRateFB>(instance_, "xrGetDisplayRefreshRateFB");
    const auto request = load<PFN_xrRequestDisplayRefreshRateFB>(instance_, "xrRequestDisplayRefreshRateFB");
    std::uint32_t count = 0;
    ASSERT_EQ(enumerate(session_, 0, &count, nullptr), XR_SUCCESS);
    std::vector<float> rates(count);
    ASSERT_EQ(enumerate(session_, count, &count, rates.data()), XR_SUCCESS);
    EXPECT_EQ(rates, (std::vector<float>{60, 72, 90}));
    EXPECT_EQ(enumerate(session_, 1, &count, rates.data()), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(request(session_, 61), XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB);
    EXPECT_EQ(request(session_, NAN), XR_ERROR_DISPLAY_REFRESH_RATE_UNSUPPORTED_FB);
    EXPECT_EQ(request(session_, 0), XR_SUCCESS);
    EXPECT_FALSE(poll(XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB));
    EXPECT_EQ(request(session_, 72), XR_SUCCESS);
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB));
    float rate = 0;
    EXPECT_EQ(get(session_, &rate), XR_SUCCESS);
    EXPECT_EQ(rate, 72);
    EXPECT_EQ(get(session_, nullptr), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(frame().predictedDisplayPeriod, 13'888'889);
}

TEST_F(ScenarioEvents, TheSessionIsPendingLossAndThenLost) {
    focusWith(R"({"frame": 4, "session_loss": {"lost_after_s": 0.05}})");
    XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, 0};
    EXPECT_EQ(waitFrame(&state), XR_SESSION_LOSS_PENDING);
    EXPECT_EQ(states(), std::vector{XR_SESSION_STATE_LOSS_PENDING});
    EXPECT_EQ(locateResult(state.predictedDisplayTime), XR_SESSION_LOSS_PENDING);
    EXPECT_EQ(beginFrame(), XR_SESSION_LOSS_PENDING);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SESSION_LOSS_PENDING);
    XrResult result = XR_SUCCESS;
    int frames = 0;
    for (; result >= 0 && frames < 20; ++frames) {
        if ((result = waitFrame(&state)) < 0) break;
        beginFrame();
        result = endFrame(state.predictedDisplayTime);
    }
    EXPECT_EQ(result, XR_ERROR_SESSION_LOST);
    EXPECT_EQ(frames, 3);  // plus the frame before the loop: four frames in 0.05 s at 90 Hz
    EXPECT_EQ(locateResult(state.predictedDisplayTime), XR_ERROR_SESSION_LOST);
    EXPECT_EQ(xrRequestExitSession(session_), XR_ERROR_SESSION_LOST);
    EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
    // A new session on the same instance works.
    const XrGraphicsBindingVulkan2KHR graphics = binding();
    ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
    const std::vector fresh{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY};
    EXPECT_EQ(states(), fresh);
}

TEST_F(ScenarioEvents, TheSessionIsLostWithoutWarning) {
    focusWith(R"({"frame": 4, "session_loss": {"lost_after_s": 0}})");
    EXPECT_EQ(waitFrame(), XR_ERROR_SESSION_LOST);
    EXPECT_TRUE(states().empty());
}

TEST_F(ScenarioEvents, TheInstanceIsLost) {
    focusWith(R"({"frame": 4, "instance_loss": {"lost_after_s": 0.03}})");
    const XrFrameState state = frameNumber(4);
    const auto event = next<XrEventDataInstanceLossPending>(XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING);
    ASSERT_TRUE(event);
    EXPECT_EQ(event->lossTime, state.predictedDisplayTime - state.predictedDisplayPeriod + 30'000'000);
    EXPECT_EQ(frame().predictedDisplayTime, state.predictedDisplayTime + state.predictedDisplayPeriod);
    EXPECT_EQ(waitFrame(), XR_ERROR_INSTANCE_LOST);
    EXPECT_EQ(pollResult(), XR_ERROR_INSTANCE_LOST);
    EXPECT_EQ(locateResult(state.predictedDisplayTime), XR_ERROR_INSTANCE_LOST);
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(xrStringToPath(instance_, "/user/hand/left", &path), XR_ERROR_INSTANCE_LOST);
    EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
}

TEST_F(ScenarioEvents, TheNthCallIsRefused) {
    focusWith(R"({"frame": 4, "refuse": {"call": "xrLocateSpace", "result": "XR_ERROR_RUNTIME_FAILURE",
                                         "nth": 2, "times": 2}})");
    EXPECT_EQ(locateResult(1'000'000'000), XR_SUCCESS);
    const XrTime time = frameNumber(4).predictedDisplayTime;
    EXPECT_EQ(locateResult(time), XR_SUCCESS);
    EXPECT_EQ(locateResult(time), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_EQ(locateResult(time), XR_ERROR_RUNTIME_FAILURE);
    EXPECT_EQ(locateResult(time), XR_SUCCESS);
}

TEST_F(ScenarioEvents, ACallIsRefusedForAWhile) {
    focusWith(R"({"frame": 4, "refuse": {"call": "xrEndFrame", "result": "XR_ERROR_OUT_OF_MEMORY",
                                         "for_s": 0.03}})");
    XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, 0};
    std::vector<XrResult> results;
    for (int i = 0; i < 4; ++i) {
        ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
        ASSERT_GE(beginFrame(), 0);  // discards the previous frame if it could not be ended
        results.push_back(endFrame(state.predictedDisplayTime));
    }
    const std::vector expected{XR_ERROR_OUT_OF_MEMORY, XR_ERROR_OUT_OF_MEMORY, XR_SUCCESS, XR_SUCCESS};
    EXPECT_EQ(results, expected);
}

TEST_F(ScenarioEvents, FramesAreLateDiscardedAndNotRendered) {
    focusWith(
        R"({"frame": 5, "frames": {"late": 3}}, {"frame": 6, "frames": {"not_rendered": true, "count": 2}},
                 {"frame": 8, "frames": {"discarded": true}})");
    const XrFrameState on_time = frameNumber(4);
    const XrFrameState late = frameNumber(5);
    EXPECT_EQ(late.predictedDisplayTime, on_time.predictedDisplayTime + 4 * on_time.predictedDisplayPeriod);
    EXPECT_TRUE(late.shouldRender);
    EXPECT_FALSE(frameNumber(6).shouldRender);
    EXPECT_FALSE(frameNumber(7).shouldRender);
    XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, 0};
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_TRUE(state.shouldRender);
    EXPECT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
}

TEST_F(ScenarioEvents, APictureIsCaptured) {
    focusWith(R"({"frame": 5, "capture": "point"})");
    const Swapchain swapchain = createSwapchain(swapchainInfo());
    cycle(swapchain.handle);
    const XrCompositionLayerQuad quad = quadLayer(stage_, swapchain, kAhead, {1, 1});
    frame({header(quad)});
    EXPECT_FALSE(std::filesystem::exists(file("point_left.png")));
    frame({header(quad)});
    EXPECT_TRUE(std::filesystem::exists(file("point_left.png")));
    EXPECT_TRUE(std::filesystem::exists(file("point_right.png")));
}

TEST_F(ScenarioEvents, EventsComeInTheOrderOfTheirTimes) {
    focusWith(R"({"t_s": 1.06, "session": "focused"}, {"t_s": 1.05, "session": "visible"})");
    std::vector<XrSessionState> seen;
    for (int i = 0; i < 8; ++i) {
        frame();
        for (const XrSessionState state : states())
            seen.push_back(state);
    }
    const std::vector expected{XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED};
    EXPECT_EQ(seen, expected);
}

TEST_F(ScenarioEvents, TheHeadFollowsARecording) {
    std::ofstream(file("head.csv")) << "t_s,x,y,z,qx,qy,qz,qw\r\n0,0,1,0,0,0,0,1\n2,2,1,0,0,0,0,1\n";
    setScript(R"({"version": 2, "head": {"csv": "head.csv"}})");
    startSession();
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    EXPECT_NEAR(locate(view, stage_, 500'000'000).pose.position.x, 0.5, 1e-6);
    EXPECT_NEAR(locate(view, stage_, 5'000'000'000).pose.position.x, 2, 1e-6);
}

TEST_F(ScenarioEvents, AHeadsetIsFoundBesideTheLibraryOrByPath) {
    std::ofstream(file("mine.json")) << R"({"version": 1, "name": "Mine", "recommended_size": [800, 600],
        "left_fov_deg": [-50, 40, 45, -45], "ipd_m": 0.07, "refresh_rates_hz": [80, 120],
        "tracking_extent_m": [2, 4], "lens": {"radius": 1}})";
    setScript(R"({"version": 2, "headset": "./mine.json"})");
    startRunning();
    auto properties = makeStruct<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    ASSERT_EQ(xrGetSystemProperties(instance_, system_, &properties), XR_SUCCESS);
    EXPECT_STREQ(properties.systemName, "Mine");
    XrExtent2Df bounds{};
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, XR_REFERENCE_SPACE_TYPE_STAGE, &bounds), XR_SUCCESS);
    EXPECT_EQ(bounds.height, 4);
    const XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                1'000'000'000, stage_};
    auto view_state = makeStruct<XrViewState>(XR_TYPE_VIEW_STATE);
    std::array views{makeStruct<XrView>(XR_TYPE_VIEW), makeStruct<XrView>(XR_TYPE_VIEW)};
    std::uint32_t count = 0;
    ASSERT_EQ(xrLocateViews(session_, &info, &view_state, 2, &count, views.data()), XR_SUCCESS);
    EXPECT_FLOAT_EQ(views[0].fov.angleLeft, static_cast<float>(-50 * M_PI / 180));
    EXPECT_FLOAT_EQ(views[1].fov.angleRight, static_cast<float>(50 * M_PI / 180));
    EXPECT_FLOAT_EQ(views[1].fov.angleLeft, static_cast<float>(-40 * M_PI / 180));
    EXPECT_FLOAT_EQ(views[1].pose.position.x - views[0].pose.position.x, 0.07F);
}

TEST_F(ScenarioEvents, EveryBuiltInHeadsetIsValid) {
    for (const char* name : {"simple", "meta_quest_3", "meta_quest_pro", "pico_4", "valve_index"}) {
        setScript(std::string(R"({"version": 2, "headset": ")") + name + "\"}");
        start();
        std::array views{makeStruct<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW),
                         makeStruct<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW)};
        std::uint32_t count = 0;
        ASSERT_EQ(xrEnumerateViewConfigurationViews(
                      instance_, system_, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2, &count, views.data()),
                  XR_SUCCESS);
        EXPECT_GE(views[0].recommendedImageRectWidth, 640U) << name;
        destroyInstance();
    }
}

}  // namespace
}  // namespace mock_test
