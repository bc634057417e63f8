// xrWaitFrame, xrBeginFrame and xrEndFrame: from several threads, in several runs, and during other calls.
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

// The session stops at 3 s and continues at 3.2 s. On the wall clock these times count from xrCreateInstance.
// They are so late that a slow machine can begin the session before the stop.
constexpr char kStopThenFocus[] = R"({"version": 1, "refresh_hz": 100, "session": [
    {"t_s": 3, "state": "stopped"}, {"t_s": 3.2, "state": "focused"}]})";

class Frames : public MockTest {
  protected:
    bool reaches(XrSessionState state) {
        const auto found = states();
        return std::find(found.begin(), found.end(), state) != found.end();
    }
    XrTime runUntilStopping() {
        XrTime last = 0;
        for (int i = 0; i < 1000; ++i) {
            last = frame().predictedDisplayTime;
            if (reaches(XR_SESSION_STATE_STOPPING)) return last;
        }
        ADD_FAILURE() << "the session was not stopped";
        return last;
    }
    void restart() {
        ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
        for (int polls = 0; polls < 600'000 && !reaches(XR_SESSION_STATE_READY); ++polls)
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        ASSERT_EQ(beginSession(), XR_SUCCESS);
    }
};

TEST_F(Frames, NullInfosAreEnough) {
    startRunning();
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(xrWaitFrame(session_, nullptr, &state), XR_SUCCESS);
    ASSERT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
    ASSERT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
    const XrFrameWaitInfo bad_wait{XR_TYPE_ACTIONS_SYNC_INFO, nullptr};
    const XrFrameBeginInfo bad_begin{XR_TYPE_UNKNOWN, nullptr};
    EXPECT_EQ(xrWaitFrame(session_, &bad_wait, &state), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(xrWaitFrame(session_, nullptr, nullptr), XR_ERROR_VALIDATION_FAILURE);
    ASSERT_EQ(xrWaitFrame(session_, nullptr, &state), XR_SUCCESS);
    EXPECT_EQ(xrBeginFrame(session_, &bad_begin), XR_ERROR_VALIDATION_FAILURE);
    ASSERT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
    EXPECT_EQ(xrEndFrame(session_, nullptr), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
}

TEST_F(Frames, ArePipelined) {
    startRunning();
    auto first = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    auto second = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&first), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    ASSERT_EQ(waitFrame(&second), XR_SUCCESS);  // before the first frame ends
    EXPECT_GT(second.predictedDisplayTime, first.predictedDisplayTime);
    EXPECT_EQ(endFrame(first.predictedDisplayTime), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_SUCCESS);  // not discarded
    EXPECT_EQ(endFrame(second.predictedDisplayTime), XR_SUCCESS);
}

TEST_F(Frames, AFailedEndLeavesTheFrameToBeDiscarded) {
    startRunning();
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    EXPECT_EQ(endFrame(0), XR_ERROR_TIME_INVALID);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_FRAME_DISCARDED);
    EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
}

TEST_F(Frames, DisplayTimesIncreaseAcrossRuns) {
    for (const char* clock : {"virtual", "real"}) {
        setVariable("XRMOCK_CLOCK", clock);
        setScript(kStopThenFocus);
        startRunning();
        const XrTime last = runUntilStopping();
        restart();
        EXPECT_GT(frame().predictedDisplayTime, last) << clock;
        EXPECT_EQ(beginFrame(), XR_ERROR_CALL_ORDER_INVALID);
        destroyAll();
    }
}

TEST_F(Frames, ANewRunStartsWithoutPendingFrames) {
    setScript(kStopThenFocus);
    startRunning();
    runUntilStopping();
    ASSERT_EQ(waitFrame(), XR_SUCCESS);  // this frame is neither begun nor ended
    std::atomic<int> number = 0;
    std::thread waiting([&] {
        number = gettid();
        EXPECT_EQ(waitFrame(), XR_ERROR_SESSION_NOT_RUNNING);
    });
    waitUntilAsleep(number);
    restart();
    waiting.join();
    EXPECT_EQ(beginFrame(), XR_ERROR_CALL_ORDER_INVALID);
    frame();
}

TEST_F(Frames, ASleepingWaitReturnsWhenTheSessionEnds) {
    setVariable("XRMOCK_CLOCK", "real");
    setScript(R"({"version": 2, "refresh_hz": 1, "events": [{"frame": 1, "frames": {"late": 120}}]})");
    startRunning();
    const auto start = std::chrono::steady_clock::now();
    std::atomic<int> number = 0;
    std::thread sleeping([&] {
        number = gettid();
        EXPECT_EQ(waitFrame(), XR_ERROR_HANDLE_INVALID);  // the frame is two minutes in the future
    });
    waitUntilAsleep(number);
    ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
    sleeping.join();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(60));
}

TEST_F(Frames, ContinueWhileOtherThreadsCall) {
    startFocused();
    std::atomic<bool> done = false;
    std::atomic<std::uint64_t> calls = 0;
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    std::vector<std::thread> others;
    for (int i = 0; i < 3; ++i) {
        others.emplace_back([&] {
            auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
            XrPath atom;
            while (!done) {
                EXPECT_EQ(xrLocateSpace(view, stage_, 1, &location), XR_SUCCESS);
                EXPECT_EQ(xrStringToPath(instance_, "/user/hand/left", &atom), XR_SUCCESS);
                ++calls;
            }
        });
    }
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 300; ++i)
        frame();
    while (calls < 300 && std::chrono::steady_clock::now() - start < std::chrono::seconds(60))
        std::this_thread::yield();
    EXPECT_GE(calls, 300U);
    done = true;
    for (std::thread& other : others)
        other.join();
}

}  // namespace
}  // namespace mock_test
