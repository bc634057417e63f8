// Scenarios with every event that can happen to a running session.
#include <chrono>

#include "show.h"

namespace stylet::xr {
namespace {

using testing::Each;
using testing::IsEmpty;

class EventsTest : public SessionTest {};

// HZ-FORCE-13
TEST_F(EventsTest, ARecentredStageIsToldWithItsTimeAndPose) {
    // A quarter turn to the left and a step, as seen from the old stage.
    useScenario(R"("events": [{"frame": 8, "recenter": {"space": "stage", "delay_s": 0.05,
        "pose": {"position": [0.5, 0, -1], "orientation": [0, 0.70710678, 0, 0.70710678]}}},
        {"frame": 8, "recenter": {"space": "local"}}])");
    Show show;
    EXPECT_EQ(show.session.facts().space, "stage");
    EXPECT_EQ(show.session.spaceGeneration(), "");
    show.run(20);
    ASSERT_EQ(show.spaces.size(), 1u) << "LOCAL is not the stage";
    const SpaceChange& change = show.spaces[0];
    EXPECT_TRUE(change.pose_valid);
    EXPECT_NEAR(change.previous_from_new.position[0], 0.5, 1e-6);
    EXPECT_NEAR(change.previous_from_new.position[2], -1.0, 1e-6);
    EXPECT_NEAR(change.previous_from_new.orientation[1], 0.70710678, 1e-6);
    // The head's pose changes at that time, not before.
    const Frame frame = show.frame();
    ASSERT_GE(frame.predicted_display_time_ns, change.at_ns);
    const double head_x = 0.1 * 1e-9 * double(frame.predicted_display_time_ns);
    EXPECT_NEAR(frame.views[0].stage_from_eye.position[0], -1.0, 0.035);
    EXPECT_NEAR(frame.views[0].stage_from_eye.position[2], head_x - 0.5 - 0.03, 1e-3);
}

TEST_F(EventsTest, AnUnknownNewPlaceIsSaidToBeUnknown) {
    useScenario(R"("events": [{"frame": 8, "recenter": {"space": "stage", "pose_valid": false}}])");
    Show show;
    show.run(12);
    ASSERT_EQ(show.spaces.size(), 1u);
    EXPECT_FALSE(show.spaces[0].pose_valid);
}

// Without a floor the stage is LOCAL with an offset. Changes of LOCAL are reported as changes of the stage.
TEST_F(EventsTest, WithoutAFloorTheStageIsBelowTheHead) {
    useScenario(R"("offers": {"spaces": []}, "events": [{"frame": 8, "recenter": {"space": "local",
        "pose": {"position": [0, 1.5, 0], "orientation": [0.70710678, 0, 0, 0.70710678]}}}])");
    Show show;
    EXPECT_EQ(show.session.facts().space, "local");
    EXPECT_THAT(show.session.notes(), testing::Contains(testing::HasSubstr("no floor")));
    ASSERT_TRUE(show.reach(SessionPhase::visible));
    const Frame before = show.frame();
    EXPECT_NEAR(before.views[0].stage_from_eye.position[1], 1.6, 1e-5);
    show.run(10);
    ASSERT_EQ(show.spaces.size(), 1u);
    // LOCAL pitches about its origin at the head, 1.6 m above the stage's origin.
    const Pose& moved = show.spaces[0].previous_from_new;
    EXPECT_NEAR(moved.position[1], 1.6, 1e-5);
    EXPECT_NEAR(moved.position[2], -1.6, 1e-5);
    EXPECT_NEAR(moved.orientation[0], 0.70710678, 1e-6);
}

TEST_F(EventsTest, TheSteadiestSpaceIsTaken) {
    useScenario(R"("offers": {"spaces": ["local_floor"]})");
    {
        Show show;
        EXPECT_EQ(show.session.facts().space, "local_floor");
        ASSERT_TRUE(show.reach(SessionPhase::visible));
        EXPECT_NEAR(show.frame().views[0].stage_from_eye.position[1], 1.5, 1e-5);
    }
    setVariable("XRMOCK_WITHHOLD", "XR_EXT_local_floor");
    {
        Show show;
        EXPECT_EQ(show.session.facts().space, "local");
    }
    setVariable("XRMOCK_WITHHOLD", "");
    useScenario(R"("offers": {"spaces": ["local_floor", "stage", "stationary"]})");
    {
        const Show show({.virtual_clock = true});
        EXPECT_EQ(show.session.facts().space, "stage") << "whose floor is the floor";
    }
    Show show;
    EXPECT_EQ(show.session.facts().space, "stationary");
    EXPECT_THAT(show.session.notes(), IsEmpty());
}

TEST_F(EventsTest, AStationarySpaceThatWasLostIsOfAnotherGeneration) {
    useScenario(R"("offers": {"spaces": ["stage", "stationary"]},
        "events": [{"frame": 6, "recenter": {"space": "stage"}},
                   {"frame": 12, "recenter": {"space": "stationary", "pose_valid": false}}])");
    std::string first;
    {
        Show show;
        first = show.session.spaceGeneration();
        EXPECT_EQ(first.size(), 36u);
        show.run(9);
        EXPECT_THAT(show.spaces, IsEmpty());
        EXPECT_EQ(show.session.spaceGeneration(), first);
        show.run(9);
        ASSERT_EQ(show.spaces.size(), 1u);
        EXPECT_FALSE(show.spaces[0].pose_valid);
        EXPECT_NE(show.session.spaceGeneration(), first);
    }
    Show again;
    EXPECT_EQ(again.session.spaceGeneration(), first) << "the same room after a restart";
}

TEST_F(EventsTest, TheHiddenAreaIsTheLensAndChangesWithIt) {
    useScenario(R"("events": [{"frame": 8, "visibility_mask": {"lens": {"outline":
        [[-10, -10], [10, -10], [10, 0.5], [-10, 0.5]]}}}])");
    Show show;
    // Round lenses hide the corners of the picture but not its centre.
    const HiddenArea round = show.session.hiddenArea(0);
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
    show.run(6);
    EXPECT_FALSE(show.news.hidden_area_changed[0]);
    show.run(6);
    EXPECT_TRUE(show.news.hidden_area_changed[0]);
    EXPECT_TRUE(show.news.hidden_area_changed[1]);
    const HiddenArea flat = show.session.hiddenArea(0);
    EXPECT_TRUE(covers(flat, 0.05, 0.6));
    EXPECT_FALSE(covers(flat, -1.2, -0.9));
}

TEST_F(EventsTest, TheHeadsetIsTakenOffAndPutOn) {
    useScenario(R"("events": [{"frame": 8, "user_presence": false}, {"frame": 14, "user_presence": true}])");
    Show show;
    show.run(6);
    ASSERT_TRUE(show.news.worn.has_value());
    EXPECT_TRUE(*show.news.worn);
    show.run(6);
    EXPECT_FALSE(*show.news.worn);
    show.run(6);
    EXPECT_TRUE(*show.news.worn);
}

TEST_F(EventsTest, TheBoundProfileIsReported) {
    useScenario(R"("controllers": {"profile": "/interaction_profiles/valve/index_controller", "right": {}},
        "events": [{"frame": 10, "interaction_profile": "/interaction_profiles/htc/vive_controller"}])");
    Show show;
    EXPECT_EQ(show.session.facts().profiles[1], "");
    show.run(8);
    EXPECT_TRUE(show.news.profiles_changed);
    EXPECT_EQ(show.session.facts().profiles[0], "");
    EXPECT_EQ(show.session.facts().profiles[1], "/interaction_profiles/valve/index_controller");
    show.news = {};
    show.run(8);
    EXPECT_TRUE(show.news.profiles_changed);
    EXPECT_EQ(show.session.facts().profiles[1], "/interaction_profiles/htc/vive_controller");
}

TEST_F(EventsTest, TheRefreshRateFollowsTheDisplay) {
    useScenario(R"("events": [{"frame": 8, "refresh_hz": 72}])");
    Show show;
    EXPECT_DOUBLE_EQ(show.session.facts().refresh_hz, 100.0);
    show.run(12);
    EXPECT_DOUBLE_EQ(show.session.facts().refresh_hz, 72.0);
}

TEST_F(EventsTest, WithoutTheExtensionTheRateIsThatOfTheFrames) {
    setVariable("XRMOCK_WITHHOLD", "XR_FB_display_refresh_rate");
    Show show;
    EXPECT_EQ(show.session.facts().refresh_hz, 0.0);
    show.run(4);
    EXPECT_NEAR(show.session.facts().refresh_hz, 100.0, 1e-3);
}

// More events than the runtime can queue. The session must assume every change that could have been among
// the lost ones.
TEST_F(EventsTest, LostEventsAreNewsOfEverything) {
    std::string many = R"("events": [)";
    for (int i = 0; i < 40; ++i)
        many += R"({"frame": 8, "visibility_mask": {}},)";
    useScenario(many + R"({"frame": 8, "recenter": {"space": "stage"}}])");
    Show show;
    ASSERT_TRUE(show.reach(SessionPhase::focused));
    show.news = {};
    show.run(10);
    EXPECT_THAT(show.session.notes(), testing::Contains(testing::HasSubstr("lost events")));
    ASSERT_EQ(show.spaces.size(), 1u);
    EXPECT_FALSE(show.spaces[0].pose_valid);
    EXPECT_TRUE(show.news.hidden_area_changed[1]);
    EXPECT_TRUE(show.news.profiles_changed);
}

// --- Frames that are not shown ---

TEST_F(EventsTest, ADiscardedFrameIsNoError) {
    useScenario(R"("events": [{"frame": 8, "frames": {"discarded": true, "count": 3}}])");
    {
        Show show;
        show.run(16);
        EXPECT_EQ(show.poll(), SessionPhase::focused);
    }
    int discarded = 0;
    for (const auto& call : calls("xrBeginFrame"))
        discarded += call["result"] == "XR_FRAME_DISCARDED";
    EXPECT_EQ(discarded, 3);
    EXPECT_EQ(frames().size(), calls("xrBeginFrame").size()) << "every frame that was begun was ended";
}

TEST_F(EventsTest, WithoutAnImageInTimeTheFrameIsEmptyAndTheWaitIsTakenUpAgain) {
    useScenario(R"("events": [{"frame": 8, "refuse": {"call": "xrWaitSwapchainImage",
        "result": "XR_TIMEOUT_EXPIRED", "times": 2}}])");
    int drawn = 0;
    {
        Show show;
        for (int i = 0; i < 14; ++i) {
            show.poll();
            if (show.session.running()) drawn += show.frame().should_render;
        }
    }
    int with_layers = 0;
    for (const auto& frame : frames())
        with_layers += !frame["layers"].empty();
    EXPECT_EQ(with_layers, drawn);
    EXPECT_EQ(calls("xrAcquireSwapchainImage").size(), std::size_t(drawn));
    EXPECT_EQ(calls("xrWaitSwapchainImage").size(), std::size_t(drawn) + 2);
}

// Even if the session state would allow drawing.
TEST_F(EventsTest, AFrameThatIsNotToBeDrawnHasNoLayers) {
    useScenario(R"("events": [{"frame": 8, "frames": {"not_rendered": true, "count": 2}}])");
    {
        Show show;
        ASSERT_TRUE(show.reach(SessionPhase::focused));
        show.run(10);
    }
    const auto all = frames();
    EXPECT_TRUE(all[7]["layers"].empty());
    EXPECT_TRUE(all[8]["layers"].empty());
    EXPECT_EQ(all[9]["layers"].size(), 1u);
}

// --- Loss ---

TEST_F(EventsTest, APendingLossEndsTheFramesAndASecondSessionWorks) {
    useScenario(R"("events": [{"frame": 8, "session_loss": {}}])");
    {
        Show show;
        ASSERT_TRUE(show.reach(SessionPhase::lossPending, 30));
        EXPECT_FALSE(show.session.running());
        EXPECT_FALSE(show.session.gripAt(1, 1).has_value());
    }
    useScenario("");
    Show again;
    EXPECT_TRUE(again.reach(SessionPhase::focused));
}

// XR_SESSION_LOSS_PENDING is a success code that any call may return.
TEST_F(EventsTest, ALossIsNoticedByWhicheverCallTellsOfIt) {
    useScenario(R"("events": [{"frame": 8, "session_loss": {"lost_after_s": 0}}])");
    Show show;
    ASSERT_TRUE(show.reach(SessionPhase::focused));
    Frame frame;
    for (int i = 0; i < 20 && show.session.running(); ++i)
        frame = show.frame();  // without polling
    EXPECT_FALSE(show.session.running());
    EXPECT_FALSE(frame.should_render);
    EXPECT_EQ(show.poll(), SessionPhase::lossPending);
    show.session.endFrame(frame);
    EXPECT_FALSE(show.session.lateUpdate(frame));
    show.session.pulse(1, 0.5f, 1'000'000);
    EXPECT_FALSE(show.session.gripAt(1, 1).has_value());
}

TEST_F(EventsTest, AnInstanceThatIsLostIsLeftAndMadeAgain) {
    useScenario(R"("events": [{"frame": 8, "instance_loss": {"lost_after_s": 0.01}}])");
    for (int round = 0; round < 3; ++round) {
        Show show;
        ASSERT_TRUE(show.reach(SessionPhase::lossPending, 30)) << round;
    }
    EXPECT_EQ(calls("xrDestroyInstance").size(), 3u);
    EXPECT_EQ(calls("xrDestroyInstance").back()["result"], "XR_SUCCESS");
}

TEST_F(EventsTest, TheLossOfEachCallIsAState) {
    for (const char* call :
         {"xrWaitFrame", "xrSyncActions", "xrGetActionStateFloat", "xrBeginFrame", "xrLocateViews",
          "xrAcquireSwapchainImage", "xrWaitSwapchainImage", "xrReleaseSwapchainImage", "xrEndFrame",
          "xrPollEvent", "xrGetCurrentInteractionProfile", "xrLocateSpace"}) {
        for (const char* result : {"XR_ERROR_SESSION_LOST", "XR_ERROR_INSTANCE_LOST"}) {
            useScenario(
                R"("events": [{"frame": 6, "interaction_profile": "/interaction_profiles/valve/index_controller"},
                {"frame": 6, "refuse": {"call": ")" +
                std::string(call) + R"(", "result": ")" + result + R"("}}])");
            Show show;
            EXPECT_TRUE(show.reach(SessionPhase::lossPending, 30)) << call << " " << result;
        }
    }
}

TEST_F(EventsTest, AnyOtherFailureThrowsOnceWithTheCallInIt) {
    useScenario(
        R"("events": [{"frame": 6, "refuse": {"call": "xrEndFrame", "result": "XR_ERROR_LAYER_INVALID"}}])");
    Show show;
    try {
        show.run(20);
        FAIL() << "nothing was thrown";
    } catch (const XrError& error) {
        EXPECT_STREQ(error.what(), "xrEndFrame: XR_ERROR_LAYER_INVALID: the runtime refuses the picture");
    }
}

}  // namespace
}  // namespace stylet::xr
