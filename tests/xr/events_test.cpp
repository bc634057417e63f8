// Tests a running session with every event that the scenarios of the mock runtime can cause.
#include <chrono>

#include "render_loop.h"

namespace stylet::xr {
namespace {

using testing::Each;
using testing::IsEmpty;

class EventsTest : public SessionTest {};

// HZ-FORCE-13
TEST_F(EventsTest, RecentringTheStageReportsTimeAndPose) {
    // In the old stage, the new origin is translated and turned by 90 degrees to the left.
    useScenario(R"("events": [{"frame": 8, "recenter": {"space": "stage", "delay_s": 0.05,
        "pose": {"position": [0.5, 0, -1], "orientation": [0, 0.70710678, 0, 0.70710678]}}},
        {"frame": 8, "recenter": {"space": "local"}}])");
    RenderLoop loop;
    EXPECT_EQ(loop.session.facts().space, "stage");
    EXPECT_EQ(loop.session.spaceGeneration(), "");
    loop.run(20);
    ASSERT_EQ(loop.spaces.size(), 1u) << "LOCAL is not the stage";
    const SpaceChange& change = loop.spaces[0];
    EXPECT_TRUE(change.pose_valid);
    EXPECT_NEAR(change.previous_from_new.position_m.x, 0.5, 1e-6);
    EXPECT_NEAR(change.previous_from_new.position_m.z, -1.0, 1e-6);
    EXPECT_NEAR(change.previous_from_new.rotation.y, 0.70710678, 1e-6);
    // The head's pose changes at that time, not before.
    const Frame frame = loop.frame();
    ASSERT_GE(frame.predicted_display_time_ns, change.at_ns);
    const double head_x = 0.1 * 1e-9 * double(frame.predicted_display_time_ns);
    EXPECT_NEAR(frame.views[0].stage_from_eye.position_m.x, -1.0, 0.035);
    EXPECT_NEAR(frame.views[0].stage_from_eye.position_m.z, head_x - 0.5 - 0.03, 1e-3);
}

TEST_F(EventsTest, RecentringWithoutAValidPoseIsReportedAsUnknown) {
    useScenario(R"("events": [{"frame": 8, "recenter": {"space": "stage", "pose_valid": false}}])");
    RenderLoop loop;
    loop.run(12);
    ASSERT_EQ(loop.spaces.size(), 1u);
    EXPECT_FALSE(loop.spaces[0].pose_valid);
}

// Without a floor the stage is LOCAL with an offset. Changes of LOCAL are reported as changes of the stage.
TEST_F(EventsTest, WithoutAFloorTheStageIsBelowTheHead) {
    useScenario(R"("offers": {"spaces": []}, "events": [{"frame": 8, "recenter": {"space": "local",
        "pose": {"position": [0, 1.5, 0], "orientation": [0.70710678, 0, 0, 0.70710678]}}}])");
    RenderLoop loop;
    EXPECT_EQ(loop.session.facts().space, "local");
    EXPECT_THAT(loop.session.notes(), testing::Contains(testing::HasSubstr("no floor")));
    ASSERT_TRUE(loop.runUntil(SessionPhase::visible));
    const Frame before = loop.frame();
    EXPECT_NEAR(before.views[0].stage_from_eye.position_m.y, 1.6, 1e-5);
    loop.run(10);
    ASSERT_EQ(loop.spaces.size(), 1u);
    // LOCAL pitches about its origin at the head, 1.6 m above the stage's origin.
    const Pose& moved = loop.spaces[0].previous_from_new;
    EXPECT_NEAR(moved.position_m.y, 1.6, 1e-5);
    EXPECT_NEAR(moved.position_m.z, -1.6, 1e-5);
    EXPECT_NEAR(moved.rotation.x, 0.70710678, 1e-6);
}

TEST_F(EventsTest, TheMostStableSpaceIsChosen) {
    useScenario(R"("offers": {"spaces": ["local_floor"]})");
    {
        RenderLoop loop;
        EXPECT_EQ(loop.session.facts().space, "local_floor");
        ASSERT_TRUE(loop.runUntil(SessionPhase::visible));
        EXPECT_NEAR(loop.frame().views[0].stage_from_eye.position_m.y, 1.5, 1e-5);
    }
    setVariable("XRMOCK_WITHHOLD", "XR_EXT_local_floor");
    {
        RenderLoop loop;
        EXPECT_EQ(loop.session.facts().space, "local");
    }
    setVariable("XRMOCK_WITHHOLD", "");
    useScenario(R"("offers": {"spaces": ["local_floor", "stage", "stationary"]})");
    {
        const RenderLoop loop({.virtual_clock = true});
        EXPECT_EQ(loop.session.facts().space, "stage") << "whose floor is the floor";
    }
    RenderLoop loop;
    EXPECT_EQ(loop.session.facts().space, "stationary");
    EXPECT_THAT(loop.session.notes(), IsEmpty());
}

TEST_F(EventsTest, ALostStationarySpaceGetsANewGeneration) {
    useScenario(R"("offers": {"spaces": ["stage", "stationary"]},
        "events": [{"frame": 6, "recenter": {"space": "stage"}},
                   {"frame": 12, "recenter": {"space": "stationary", "pose_valid": false}}])");
    std::string first;
    {
        RenderLoop loop;
        first = loop.session.spaceGeneration();
        EXPECT_EQ(first.size(), 36u);
        loop.run(9);
        EXPECT_THAT(loop.spaces, IsEmpty());
        EXPECT_EQ(loop.session.spaceGeneration(), first);
        loop.run(9);
        ASSERT_EQ(loop.spaces.size(), 1u);
        EXPECT_FALSE(loop.spaces[0].pose_valid);
        EXPECT_NE(loop.session.spaceGeneration(), first);
    }
    RenderLoop again;
    EXPECT_EQ(again.session.spaceGeneration(), first) << "the same room after a restart";
}

TEST_F(EventsTest, TheHiddenAreaFollowsTheLensOutline) {
    useScenario(R"("events": [{"frame": 8, "visibility_mask": {"lens": {"outline":
        [[-10, -10], [10, -10], [10, 0.5], [-10, 0.5]]}}}])");
    RenderLoop loop;
    // Round lenses hide the corners of the picture but not its centre.
    const HiddenArea round = loop.session.hiddenArea(0);
    ASSERT_FALSE(round.indices.empty());
    const auto covers = [](const HiddenArea& area, double x, double y) {
        for (std::size_t i = 0; i < area.indices.size(); i += 3) {
            int left = 0, right = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto& a = area.tangents[area.indices[i + k]];
                const auto& b = area.tangents[area.indices[i + (k + 1) % 3]];
                const double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
                (side >= 0 ? left : right) += 1;
            }
            if (left == 3 || right == 3) return true;
        }
        return false;
    };
    EXPECT_TRUE(covers(round, -1.2, 1.0));
    EXPECT_FALSE(covers(round, 0.05, 0.05));
    loop.run(6);
    EXPECT_FALSE(loop.events.hidden_area_changed[0]);
    loop.run(6);
    EXPECT_TRUE(loop.events.hidden_area_changed[0]);
    EXPECT_TRUE(loop.events.hidden_area_changed[1]);
    const HiddenArea flat = loop.session.hiddenArea(0);
    EXPECT_TRUE(covers(flat, 0.05, 0.6));
    EXPECT_FALSE(covers(flat, -1.2, -0.9));
}

TEST_F(EventsTest, UserPresenceIsReported) {
    useScenario(R"("events": [{"frame": 8, "user_presence": false}, {"frame": 14, "user_presence": true}])");
    RenderLoop loop;
    loop.run(6);
    ASSERT_TRUE(loop.events.worn.has_value());
    EXPECT_TRUE(*loop.events.worn);
    loop.run(6);
    EXPECT_FALSE(*loop.events.worn);
    loop.run(6);
    EXPECT_TRUE(*loop.events.worn);
}

TEST_F(EventsTest, TheBoundProfileIsReported) {
    useScenario(R"("controllers": {"profile": "/interaction_profiles/valve/index_controller", "right": {}},
        "events": [{"frame": 10, "interaction_profile": "/interaction_profiles/htc/vive_controller"}])");
    RenderLoop loop;
    EXPECT_EQ(loop.session.facts().profiles[1], "");
    loop.run(8);
    EXPECT_TRUE(loop.events.profiles_changed);
    EXPECT_EQ(loop.session.facts().profiles[0], "");
    EXPECT_EQ(loop.session.facts().profiles[1], "/interaction_profiles/valve/index_controller");
    loop.events = {};
    loop.run(8);
    EXPECT_TRUE(loop.events.profiles_changed);
    EXPECT_EQ(loop.session.facts().profiles[1], "/interaction_profiles/htc/vive_controller");
}

TEST_F(EventsTest, TheRefreshRateFollowsTheDisplay) {
    useScenario(R"("events": [{"frame": 8, "refresh_hz": 72}])");
    RenderLoop loop;
    EXPECT_DOUBLE_EQ(loop.session.facts().refresh_hz, 100.0);
    loop.run(12);
    EXPECT_DOUBLE_EQ(loop.session.facts().refresh_hz, 72.0);
}

TEST_F(EventsTest, WithoutTheExtensionTheRefreshRateComesFromTheFramePeriod) {
    setVariable("XRMOCK_WITHHOLD", "XR_FB_display_refresh_rate");
    RenderLoop loop;
    EXPECT_EQ(loop.session.facts().refresh_hz, 0.0);
    loop.run(4);
    EXPECT_NEAR(loop.session.facts().refresh_hz, 100.0, 1e-3);
}

// The runtime gets more events than it can queue. The session must assume that every kind of change was among
// the lost events.
TEST_F(EventsTest, LostEventsReportEverythingAsChanged) {
    std::string many = R"("events": [)";
    for (int i = 0; i < 40; ++i)
        many += R"({"frame": 8, "visibility_mask": {}},)";
    useScenario(many + R"({"frame": 8, "recenter": {"space": "stage"}}])");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.events = {};
    loop.run(10);
    EXPECT_THAT(loop.session.notes(), testing::Contains(testing::HasSubstr("lost events")));
    ASSERT_EQ(loop.spaces.size(), 1u);
    EXPECT_FALSE(loop.spaces[0].pose_valid);
    EXPECT_TRUE(loop.events.hidden_area_changed[1]);
    EXPECT_TRUE(loop.events.profiles_changed);
}

// --- Frames that are not shown ---

TEST_F(EventsTest, ADiscardedFrameIsNotAnError) {
    useScenario(R"("events": [{"frame": 8, "frames": {"discarded": true, "count": 3}}])");
    {
        RenderLoop loop;
        loop.run(16);
        EXPECT_EQ(loop.poll(), SessionPhase::focused);
    }
    int discarded = 0;
    for (const auto& call : calls("xrBeginFrame"))
        discarded += call["result"] == "XR_FRAME_DISCARDED";
    EXPECT_EQ(discarded, 3);
    EXPECT_EQ(frames().size(), calls("xrBeginFrame").size()) << "every frame that was begun was ended";
}

TEST_F(EventsTest, AnImageTimeoutGivesAnEmptyFrameAndTheNextFrameContinuesWaiting) {
    useScenario(R"("events": [{"frame": 8, "refuse": {"call": "xrWaitSwapchainImage",
        "result": "XR_TIMEOUT_EXPIRED", "times": 2}}])");
    int drawn = 0;
    {
        RenderLoop loop;
        for (int i = 0; i < 14; ++i) {
            loop.poll();
            if (loop.session.running()) drawn += loop.frame().should_render;
        }
    }
    int with_layers = 0;
    for (const auto& frame : frames())
        with_layers += !frame["layers"].empty();
    EXPECT_EQ(with_layers, drawn);
    EXPECT_EQ(calls("xrAcquireSwapchainImage").size(), std::size_t(drawn));
    EXPECT_EQ(calls("xrWaitSwapchainImage").size(), std::size_t(drawn) + 2);
}

// shouldRender is false although the session is focused.
TEST_F(EventsTest, AFrameThatShouldNotRenderHasNoLayers) {
    useScenario(R"("events": [{"frame": 8, "frames": {"not_rendered": true, "count": 2}}])");
    {
        RenderLoop loop;
        ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
        loop.run(10);
    }
    const auto all = frames();
    EXPECT_TRUE(all[7]["layers"].empty());
    EXPECT_TRUE(all[8]["layers"].empty());
    EXPECT_EQ(all[9]["layers"].size(), 1u);
}

// --- Loss ---

TEST_F(EventsTest, APendingLossEndsTheSessionAndASecondSessionWorks) {
    useScenario(R"("events": [{"frame": 8, "session_loss": {}}])");
    {
        RenderLoop loop;
        ASSERT_TRUE(loop.runUntil(SessionPhase::lossPending, 30));
        EXPECT_FALSE(loop.session.running());
        EXPECT_FALSE(loop.session.gripAt(1, 1).has_value());
    }
    useScenario("");
    RenderLoop again;
    EXPECT_TRUE(again.runUntil(SessionPhase::focused));
}

// XR_SESSION_LOSS_PENDING is a success code that any call may return.
TEST_F(EventsTest, EveryCallCanReportALoss) {
    useScenario(R"("events": [{"frame": 8, "session_loss": {"lost_after_s": 0}}])");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    Frame frame;
    for (int i = 0; i < 20 && loop.session.running(); ++i)
        frame = loop.frame();  // without polling
    EXPECT_FALSE(loop.session.running());
    EXPECT_FALSE(frame.should_render);
    EXPECT_EQ(loop.poll(), SessionPhase::lossPending);
    loop.session.endFrame(frame);
    EXPECT_FALSE(loop.session.lateUpdate(frame));
    loop.session.pulse(1, 0.5f, 1'000'000);
    EXPECT_FALSE(loop.session.gripAt(1, 1).has_value());
}

TEST_F(EventsTest, ALostInstanceCanBeRecreated) {
    useScenario(R"("events": [{"frame": 8, "instance_loss": {"lost_after_s": 0.01}}])");
    for (int round = 0; round < 3; ++round) {
        RenderLoop loop;
        ASSERT_TRUE(loop.runUntil(SessionPhase::lossPending, 30)) << round;
    }
    EXPECT_EQ(calls("xrDestroyInstance").size(), 3u);
    EXPECT_EQ(calls("xrDestroyInstance").back()["result"], "XR_SUCCESS");
}

TEST_F(EventsTest, ALossReportedByAnyCallChangesTheState) {
    for (const char* call :
         {"xrWaitFrame", "xrSyncActions", "xrGetActionStateFloat", "xrBeginFrame", "xrLocateViews",
          "xrAcquireSwapchainImage", "xrWaitSwapchainImage", "xrReleaseSwapchainImage", "xrEndFrame",
          "xrPollEvent", "xrGetCurrentInteractionProfile", "xrLocateSpace"}) {
        for (const char* result : {"XR_ERROR_SESSION_LOST", "XR_ERROR_INSTANCE_LOST"}) {
            useScenario(
                R"("events": [{"frame": 6, "interaction_profile": "/interaction_profiles/valve/index_controller"},
                {"frame": 6, "refuse": {"call": ")" +
                std::string(call) + R"(", "result": ")" + result + R"("}}])");
            RenderLoop loop;
            EXPECT_TRUE(loop.runUntil(SessionPhase::lossPending, 30)) << call << " " << result;
        }
    }
}

TEST_F(EventsTest, AnyOtherFailureThrowsOnceAndNamesTheCall) {
    useScenario(
        R"("events": [{"frame": 6, "refuse": {"call": "xrEndFrame", "result": "XR_ERROR_LAYER_INVALID"}}])");
    RenderLoop loop;
    try {
        loop.run(20);
        FAIL() << "nothing was thrown";
    } catch (const XrError& error) {
        EXPECT_STREQ(error.what(), "xrEndFrame: XR_ERROR_LAYER_INVALID: the runtime refuses the frame");
    }
}

}  // namespace
}  // namespace stylet::xr
