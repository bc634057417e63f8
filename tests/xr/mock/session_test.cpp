#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

using States = std::vector<XrSessionState>;

class Session : public MockTest {
  protected:
};

TEST_F(Session, NeedsAValidGraphicsBinding) {
    start();
    XrSession session;
    EXPECT_EQ(trySession(nullptr, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    auto graphics = makeStruct<XrGraphicsBindingVulkan2KHR>(XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
    EXPECT_EQ(trySession(&graphics, &session), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
    xrDestroyInstance(instance_);
    startVulkan();
    EXPECT_EQ(trySession(&graphics, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    graphics.physicalDevice = VK_NULL_HANDLE;
    EXPECT_EQ(trySession(&graphics, &session), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    system_ += 1;
    EXPECT_EQ(trySession(&graphics, &session), XR_ERROR_SYSTEM_INVALID);
    system_ -= 1;
    ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
    EXPECT_EQ(trySession(&graphics, &session), XR_ERROR_LIMIT_REACHED);
}

TEST_F(Session, PassesThroughAllStates) {
    startSession();
    EXPECT_EQ(states(), (States{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY}));
    EXPECT_EQ(waitFrame(), XR_ERROR_SESSION_NOT_RUNNING);
    EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
    EXPECT_EQ(xrRequestExitSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
    ASSERT_EQ(beginSession(), XR_SUCCESS);
    EXPECT_EQ(beginSession(), XR_ERROR_SESSION_RUNNING);
    EXPECT_EQ(states(), States{});
    EXPECT_FALSE(frame().shouldRender);
    EXPECT_EQ(states(), States{XR_SESSION_STATE_SYNCHRONIZED});
    EXPECT_FALSE(frame().shouldRender);
    EXPECT_EQ(states(), States{XR_SESSION_STATE_VISIBLE});
    EXPECT_TRUE(frame().shouldRender);
    EXPECT_EQ(states(), States{XR_SESSION_STATE_FOCUSED});
    EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_STOPPING);
    ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
    EXPECT_EQ(states(),
              (States{XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING}));
    EXPECT_FALSE(frame().shouldRender);
    ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
    EXPECT_EQ(states(), (States{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_EXITING}));
    EXPECT_EQ(beginSession(), XR_ERROR_SESSION_NOT_READY);
}

TEST_F(Session, RefusesOtherViewConfigurations) {
    startSession();
    XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO};
    EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    info.primaryViewConfigurationType = static_cast<XrViewConfigurationType>(7);
    EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Session, CanExitBeforeTheFirstFrame) {
    startRunning();
    states();
    ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
    EXPECT_EQ(states(), (States{XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING}));
}

TEST_F(Session, FollowsTheScenario) {
    setScript(
        R"({"version": 1, "session": [{"t_s": 1.2, "state": "visible"}, {"t_s": 1.4, "state": "focused"},
                  {"t_s": 1.6, "state": "stopped"}, {"t_s": 3, "state": "focused"}]})");
    startFocused();
    XrTime time = 0;
    while ((time = frame().predictedDisplayTime) < 1'200'000'000)
        EXPECT_EQ(states(), States{});
    EXPECT_EQ(states(), States{XR_SESSION_STATE_VISIBLE});
    while ((time = frame().predictedDisplayTime) < 1'400'000'000)
        EXPECT_EQ(states(), States{});
    EXPECT_EQ(states(), States{XR_SESSION_STATE_FOCUSED});
    while ((time = frame().predictedDisplayTime) < 1'600'000'000)
        EXPECT_EQ(states(), States{});
    EXPECT_EQ(states(),
              (States{XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING}));
    ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
    EXPECT_EQ(states(), States{XR_SESSION_STATE_IDLE});
    States later;
    for (int polls = 0; later.empty() && polls < 200; ++polls)
        later = states();
    EXPECT_EQ(later, States{XR_SESSION_STATE_READY});
    EXPECT_EQ(beginSession(), XR_SUCCESS);
    EXPECT_GE(frame().predictedDisplayTime, 3'000'000'000);
}

TEST_F(Session, ExitsAfterTheScriptedNumberOfFrames) {
    setScript(R"({"version": 1, "exit_after_frames": 5})");
    startRunning();
    states();
    for (int i = 0; i < 4; ++i)
        frame();
    EXPECT_EQ(states().back(), XR_SESSION_STATE_FOCUSED);
    frame();
    EXPECT_EQ(states().back(), XR_SESSION_STATE_STOPPING);
}

TEST_F(Session, ReportsLostEvents) {
    std::string scenario = R"({"version": 1, "session": [{"t_s": 0, "state": "focused"})";
    for (int i = 0; i < 100; ++i) {
        scenario += ", {\"t_s\": " + std::to_string(1.1 + i * 0.02) + ", \"state\": \"" +
                    (i % 2 == 0 ? "visible" : "focused") + "\"}";
    }
    setScript(scenario + "]}");
    startRunning();
    for (int i = 0; i < 300; ++i)
        frame();
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_EVENTS_LOST).has_value());
    EXPECT_FALSE(poll(XR_TYPE_EVENT_DATA_EVENTS_LOST).has_value());
}

TEST_F(Session, FrameCallsMustBeInOrder) {
    startRunning();
    EXPECT_EQ(beginFrame(), XR_ERROR_CALL_ORDER_INVALID);
    EXPECT_EQ(endFrame(1), XR_ERROR_CALL_ORDER_INVALID);
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    EXPECT_EQ(endFrame(1), XR_ERROR_CALL_ORDER_INVALID);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_ERROR_CALL_ORDER_INVALID);
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    EXPECT_EQ(endFrame(0), XR_ERROR_TIME_INVALID);
    EXPECT_EQ(endFrame(-5), XR_ERROR_TIME_INVALID);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_ERROR_CALL_ORDER_INVALID);
}

TEST_F(Session, VirtualTimeAdvancesByOnePeriodAFrame) {
    setScript(R"({"version": 1, "refresh_hz": 100})");
    startRunning();
    for (int i = 0; i < 50; ++i) {
        const XrFrameState state = frame();
        EXPECT_EQ(state.predictedDisplayTime, 1'000'000'000 + i * 10'000'000);
        EXPECT_EQ(state.predictedDisplayPeriod, 10'000'000);
    }
}

// Uses real time, because only the wall clock paces frames. The limits are lower bounds, because a busy
// machine only delays frames.
TEST_F(Session, RealTimeIsPaced) {
    setVariable("XRMOCK_CLOCK", "real");
    setScript(R"({"version": 1, "refresh_hz": 200})");
    startRunning();
    XrTime last = frame().predictedDisplayTime;
    const XrTime first = last;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 20; ++i) {
        const XrTime time = frame().predictedDisplayTime;
        EXPECT_GT(time, last);
        EXPECT_EQ((time - first) % 5'000'000, 0);
        last = time;
    }
    const auto spent = std::chrono::steady_clock::now() - start;
    EXPECT_GE(spent, std::chrono::milliseconds(90));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_GE(frame().predictedDisplayTime - last, 45'000'000);  // missed frames are skipped
}

TEST_F(Session, ASecondWaitBlocksUntilTheFrameIsBegun) {
    startRunning();
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    std::atomic<bool> second_returned = false;
    std::atomic<int> number = 0;
    std::thread second([&] {
        number = gettid();
        EXPECT_EQ(waitFrame(), XR_SUCCESS);
        second_returned = true;
    });
    waitUntilAsleep(number);
    EXPECT_FALSE(second_returned);
    EXPECT_EQ(beginFrame(), XR_SUCCESS);
    second.join();
    EXPECT_TRUE(second_returned);
}

TEST_F(Session, AWaitingThreadReturnsWhenTheSessionEnds) {
    startRunning();
    ASSERT_EQ(waitFrame(), XR_SUCCESS);
    std::atomic<int> number = 0;
    std::thread second([&] {
        number = gettid();
        EXPECT_EQ(waitFrame(), XR_ERROR_SESSION_NOT_RUNNING);
    });
    waitUntilAsleep(number);
    ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
    ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
    second.join();
}

}  // namespace
}  // namespace mock_test
