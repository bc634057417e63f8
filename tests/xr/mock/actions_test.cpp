#include "tests/xr/mock/client/actions_client.h"

namespace mock_test {
namespace {

TEST_F(Actions, NamesAreChecked) {
    start();
    XrActionSet set = XR_NULL_HANDLE, other = XR_NULL_HANDLE;
    EXPECT_EQ(tryActionSet("", "x", &set), XR_ERROR_NAME_INVALID);
    EXPECT_EQ(tryActionSet("x", "", &set), XR_ERROR_LOCALIZED_NAME_INVALID);
    EXPECT_EQ(tryActionSet("Upper", "x", &set), XR_ERROR_PATH_FORMAT_INVALID);
    EXPECT_EQ(tryActionSet("a b", "x", &set), XR_ERROR_PATH_FORMAT_INVALID);
    ASSERT_EQ(tryActionSet("one", "One", &set), XR_SUCCESS);
    EXPECT_EQ(tryActionSet("one", "Two", &other), XR_ERROR_NAME_DUPLICATED);
    EXPECT_EQ(tryActionSet("two", "One", &other), XR_ERROR_LOCALIZED_NAME_DUPLICATED);
    ASSERT_EQ(xrDestroyActionSet(set), XR_SUCCESS);
    ASSERT_EQ(tryActionSet("one", "One", &set), XR_SUCCESS);

    XrAction action = XR_NULL_HANDLE;
    constexpr auto kBoolean = XR_ACTION_TYPE_BOOLEAN_INPUT;
    EXPECT_EQ(tryAction(set, "", "x", kBoolean, {}, &action), XR_ERROR_NAME_INVALID);
    EXPECT_EQ(tryAction(set, "a", "a", static_cast<XrActionType>(77), {}, &action),
              XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(tryAction(set, "a", "a", kBoolean, {XR_NULL_PATH}, &action), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(tryAction(set, "a", "a", kBoolean, {path("/user/hand/left/input")}, &action),
              XR_ERROR_PATH_UNSUPPORTED);
    const XrPath left = path("/user/hand/left");
    EXPECT_EQ(tryAction(set, "a", "a", kBoolean, {left, left}, &action), XR_ERROR_PATH_UNSUPPORTED);
    ASSERT_EQ(tryAction(set, "a", "A", kBoolean, {left}, &action), XR_SUCCESS);
    EXPECT_EQ(tryAction(set, "a", "B", kBoolean, {}, &action), XR_ERROR_NAME_DUPLICATED);
    EXPECT_EQ(tryAction(set, "b", "A", kBoolean, {}, &action), XR_ERROR_LOCALIZED_NAME_DUPLICATED);
}

TEST_F(Actions, SuggestionsFollowTheProfile) {
    start();
    const XrActionSet set = actionSet("set");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    EXPECT_EQ(suggest(kSimple, {}), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(suggest("/interaction_profiles/khr/other", {{press, "/user/hand/left/input/select/click"}}),
              XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/trigger/value"}}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/gamepad/input/select/click"}}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left"}}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input"}}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select"}}), XR_SUCCESS);
    EXPECT_EQ(suggest(kTouch,
                      {{press, "/user/hand/left/input/x/click"}, {press, "/user/hand/right/input/a/click"}}),
              XR_SUCCESS);
    EXPECT_EQ(suggest(kTouch, {{press, "/user/hand/right/input/x/click"}}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(
        suggest("/interaction_profiles/microsoft/xbox_controller", {{press, "/user/gamepad/input/a/click"}}),
        XR_SUCCESS);
    ASSERT_EQ(xrDestroyAction(press), XR_SUCCESS);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select"}}), XR_ERROR_HANDLE_INVALID);
}

TEST_F(Actions, AttachingFreezesTheSets) {
    startSession();
    const XrActionSet set = actionSet("set"), loose = actionSet("loose");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction stray = action(loose, "stray", XR_ACTION_TYPE_BOOLEAN_INPUT);
    auto profile = makeStruct<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
    EXPECT_EQ(xrGetCurrentInteractionProfile(session_, path("/user/hand/left"), &profile),
              XR_ERROR_ACTIONSET_NOT_ATTACHED);
    auto state = makeStruct<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
    auto info = of(press);
    EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_ACTIONSET_NOT_ATTACHED);
    EXPECT_EQ(attach({}), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(sync({set}), XR_ERROR_ACTIONSET_NOT_ATTACHED);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    EXPECT_EQ(attach({set}), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
    XrAction late = XR_NULL_HANDLE;
    EXPECT_EQ(tryAction(set, "late", "late", XR_ACTION_TYPE_BOOLEAN_INPUT, {}, &late),
              XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
    EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select/click"}}),
              XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
    EXPECT_EQ(sync({loose}), XR_ERROR_ACTIONSET_NOT_ATTACHED);
    info = of(stray);
    EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_ACTIONSET_NOT_ATTACHED);
    EXPECT_EQ(sync({set}), XR_SESSION_NOT_FOCUSED);
    EXPECT_EQ(boolean(press).isActive, XR_FALSE);
    EXPECT_EQ(xrGetCurrentInteractionProfile(session_, XR_NULL_PATH, &profile), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(xrGetCurrentInteractionProfile(session_, path("/user/hand"), &profile),
              XR_ERROR_PATH_UNSUPPORTED);
}

constexpr char kPresses[] = R"({"version": 1, "refresh_hz": 100, "controllers": {
    "left": {"poses": [{"t_s": 0, "position": [-1, 1, 0]}],
             "values": [{"t_s": 1.1, "select/click": true}, {"t_s": 1.2, "select/click": false}]},
    "right": {"poses": [{"t_s": 0, "position": [1, 1, 0]}, {"t_s": 2, "position": [1, 3, 0]}],
              "values": [{"t_s": 1.15, "select/click": 1, "menu/click": 1}]}}})";

TEST_F(Actions, StatesFollowTheScenario) {
    setScript(kPresses);
    startFocused();
    const XrPath left = path("/user/hand/left"), right = path("/user/hand/right");
    const XrActionSet set = actionSet("set");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT, {left, right});
    const XrAction analogue = action(set, "analogue", XR_ACTION_TYPE_FLOAT_INPUT);
    const XrAction unbound = action(set, "unbound", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select/click"},
                                {press, "/user/hand/right/input/select"},
                                {analogue, "/user/hand/left/input/select/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());
    auto profile = makeStruct<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
    ASSERT_EQ(xrGetCurrentInteractionProfile(session_, left, &profile), XR_SUCCESS);
    EXPECT_EQ(profile.interactionProfile, path(kSimple));

    int rises = 0, falls = 0;
    XrTime rise_time = 0;
    for (XrTime time = 0; time < 1'300'000'000;) {
        time = frame().predictedDisplayTime;
        ASSERT_EQ(sync({set}), XR_SUCCESS);
        const auto l = boolean(press, left), r = boolean(press, right), any = boolean(press);
        EXPECT_TRUE(l.isActive && r.isActive && any.isActive);
        EXPECT_FALSE(boolean(unbound).isActive);
        EXPECT_EQ(l.currentState, time >= 1'100'000'000 && time < 1'200'000'000);
        EXPECT_EQ(r.currentState, time >= 1'150'000'000);
        EXPECT_EQ(any.currentState, l.currentState || r.currentState);
        EXPECT_EQ(number(analogue).currentState, l.currentState ? 1.0F : 0.0F);
        if (l.changedSinceLastSync) {
            (l.currentState ? rises : falls) += 1;
            if (l.currentState) rise_time = time;
        }
        if (l.currentState) {
            EXPECT_EQ(l.lastChangeTime, rise_time);
        }
    }
    EXPECT_EQ(rises, 1);
    EXPECT_EQ(falls, 1);

    ASSERT_EQ(sync({}), XR_SUCCESS);
    EXPECT_FALSE(boolean(press).isActive);
    ASSERT_EQ(sync({set}, left), XR_SUCCESS);
    EXPECT_TRUE(boolean(press, left).isActive);
    EXPECT_FALSE(boolean(press, right).isActive);
}

TEST_F(Actions, WrongTypesAndPathsAreRefused) {
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT, {path("/user/hand/left")});
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    auto wrong = makeStruct<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
    auto info = of(press);
    EXPECT_EQ(xrGetActionStateFloat(session_, &info, &wrong), XR_ERROR_ACTION_TYPE_MISMATCH);
    auto state = makeStruct<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
    info = of(press, path("/user/hand/right"));
    EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_PATH_UNSUPPORTED);
    info = of(press, 4711);
    EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(sync({set}, path("/user/hand/right")), XR_ERROR_PATH_UNSUPPORTED);
    const XrActionSpaceCreateInfo space_info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, press, XR_NULL_PATH,
                                             kIdentity};
    XrSpace space = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateActionSpace(session_, &space_info, &space), XR_ERROR_ACTION_TYPE_MISMATCH);
}

TEST_F(Actions, TheHigherPrioritySetReceivesTheSource) {
    setScript(kPresses);
    startFocused();
    const XrActionSet low = actionSet("low", 1), high = actionSet("high", 2);
    const XrAction low_select = action(low, "low_select", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction low_menu = action(low, "low_menu", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction high_select = action(high, "high_select", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{low_select, "/user/hand/left/input/select/click"},
                                {low_menu, "/user/hand/left/input/menu/click"},
                                {high_select, "/user/hand/left/input/select/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({low, high}), XR_SUCCESS);
    ASSERT_EQ(sync({low, high}), XR_SUCCESS);
    EXPECT_FALSE(boolean(low_select).isActive);
    EXPECT_TRUE(boolean(low_menu).isActive);
    EXPECT_TRUE(boolean(high_select).isActive);
    ASSERT_EQ(sync({low}), XR_SUCCESS);
    EXPECT_TRUE(boolean(low_select).isActive);
    EXPECT_FALSE(boolean(high_select).isActive);
}

TEST_F(Actions, HandsAreLocatedWhileTheyAreActive) {
    setScript(kPresses);
    startFocused();
    const XrPath right = path("/user/hand/right");
    const XrActionSet set = actionSet("set");
    const XrAction grip = action(set, "grip", XR_ACTION_TYPE_POSE_INPUT, {right});
    ASSERT_EQ(suggest(kSimple, {{grip, "/user/hand/right/input/grip/pose"}}), XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    const XrActionSpaceCreateInfo info{
        XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, grip, right, {{0, 0, 0, 1}, {0, 0, -0.1F}}};
    XrSpace space = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateActionSpace(session_, &info, &space), XR_SUCCESS);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    ASSERT_EQ(xrLocateSpace(space, stage_, 1'000'000'000, &location), XR_SUCCESS);
    EXPECT_EQ(location.locationFlags, 0U);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    auto pose = makeStruct<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE);
    const auto get = of(grip, right);
    ASSERT_EQ(xrGetActionStatePose(session_, &get, &pose), XR_SUCCESS);
    EXPECT_TRUE(pose.isActive);
    ASSERT_EQ(xrLocateSpace(space, stage_, 1'000'000'000, &location), XR_SUCCESS);
    EXPECT_EQ(location.locationFlags, 15U);
    EXPECT_FLOAT_EQ(location.pose.position.x, 1);
    EXPECT_FLOAT_EQ(location.pose.position.y, 2);
    EXPECT_FLOAT_EQ(location.pose.position.z, -0.1F);
    ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
    ASSERT_EQ(xrLocateSpace(space, stage_, 1'000'000'000, &location), XR_SUCCESS);
    EXPECT_EQ(location.locationFlags, 0U);
}

TEST_F(Actions, SourcesHaveNames) {
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select/click"},
                                {press, "/user/hand/right/input/menu/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr,
                                                    press};
    std::uint32_t count = 0;
    ASSERT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 0, &count, nullptr), XR_SUCCESS);
    ASSERT_EQ(count, 2U);
    std::array<XrPath, 2> sources{};
    EXPECT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 1, &count, sources.data()),
              XR_ERROR_SIZE_INSUFFICIENT);
    ASSERT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 2, &count, sources.data()), XR_SUCCESS);
    XrInputSourceLocalizedNameGetInfo name_info{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr,
                                                sources[1], 7};
    char name[64];
    ASSERT_EQ(xrGetInputSourceLocalizedName(session_, &name_info, sizeof name, &count, name), XR_SUCCESS);
    EXPECT_STREQ(name, "Right Hand Simple Controller Menu");
    name_info.whichComponents = XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;
    ASSERT_EQ(xrGetInputSourceLocalizedName(session_, &name_info, sizeof name, &count, name), XR_SUCCESS);
    EXPECT_STREQ(name, "Menu");
    EXPECT_EQ(count, 5U);
    name_info.whichComponents = 0;
    EXPECT_EQ(xrGetInputSourceLocalizedName(session_, &name_info, sizeof name, &count, name),
              XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Actions, HapticsNeedFocusAndAVibrationAction) {
    startRunning();
    const XrActionSet set = actionSet("set");
    const XrAction buzz = action(set, "buzz", XR_ACTION_TYPE_VIBRATION_OUTPUT);
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{buzz, "/user/hand/left/output/haptic"}}), XR_SUCCESS);
    const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, XR_MIN_HAPTIC_DURATION, 0, 1};
    const auto* feedback = reinterpret_cast<const XrHapticBaseHeader*>(&vibration);
    XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, buzz, XR_NULL_PATH};
    EXPECT_EQ(xrApplyHapticFeedback(session_, &info, feedback), XR_ERROR_ACTIONSET_NOT_ATTACHED);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    EXPECT_EQ(xrApplyHapticFeedback(session_, &info, feedback), XR_SESSION_NOT_FOCUSED);
    for (int i = 0; i < 3; ++i)
        frame();
    EXPECT_EQ(xrApplyHapticFeedback(session_, &info, feedback), XR_SUCCESS);
    EXPECT_EQ(xrStopHapticFeedback(session_, &info), XR_SUCCESS);
    EXPECT_EQ(xrApplyHapticFeedback(session_, &info, nullptr), XR_ERROR_VALIDATION_FAILURE);
    info.action = press;
    EXPECT_EQ(xrApplyHapticFeedback(session_, &info, feedback), XR_ERROR_ACTION_TYPE_MISMATCH);
}

TEST_F(Actions, AttachedActionsOutliveTheirHandles) {
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction grip = action(set, "grip", XR_ACTION_TYPE_POSE_INPUT);
    ASSERT_EQ(suggest(kSimple, {{grip, "/user/hand/left/input/grip/pose"}}), XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, grip, XR_NULL_PATH,
                                       kIdentity};
    XrSpace space = XR_NULL_HANDLE;
    ASSERT_EQ(xrCreateActionSpace(session_, &info, &space), XR_SUCCESS);
    ASSERT_EQ(xrDestroyActionSet(set), XR_SUCCESS);
    EXPECT_EQ(xrDestroyAction(grip), XR_ERROR_HANDLE_INVALID);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    ASSERT_EQ(xrLocateSpace(space, stage_, 1, &location), XR_SUCCESS);
    EXPECT_EQ(location.locationFlags, 15U);
}

TEST_F(Actions, ProfilesOfExtensionsNeedTheExtension) {
    constexpr char kHp[] = "/interaction_profiles/hp/mixed_reality_controller";
    constexpr char kFocus3[] = "/interaction_profiles/htc/vive_focus3_controller";
    for (const bool enabled : {false, true}) {
        extensions_ = {"XR_KHR_vulkan_enable2"};
        if (enabled)
            for (const char* each : {"XR_EXT_hp_mixed_reality_controller", "XR_EXT_palm_pose",
                                     "XR_HTC_vive_focus3_controller_interaction"})
                extensions_.push_back(each);
        start();
        const XrActionSet set = actionSet("set");
        const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
        const XrResult expected = enabled ? XR_SUCCESS : XR_ERROR_PATH_UNSUPPORTED;
        EXPECT_EQ(suggest(kHp, {{press, "/user/hand/right/input/a/click"}}), expected);
        EXPECT_EQ(suggest(kFocus3, {{press, "/user/hand/left/input/squeeze"}}), expected);
        EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/palm_ext/pose"}}), expected);
        EXPECT_EQ(suggest(kTouch, {{press, "/user/hand/left/input/palm_ext"}}), expected);
        // Paths that only OpenXR 1.1 defines are not supported.
        EXPECT_EQ(suggest(kTouch, {{press, "/user/hand/left/input/trigger/proximity"}}),
                  XR_ERROR_PATH_UNSUPPORTED);
        EXPECT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/grip_surface/pose"}}),
                  XR_ERROR_PATH_UNSUPPORTED);
        EXPECT_EQ(suggest("/interaction_profiles/samsung/odyssey_controller",
                          {{press, "/user/hand/left/input/menu/click"}}),
                  XR_ERROR_PATH_UNSUPPORTED);
        destroyInstance();
    }
}

// XR_EXT_palm_pose: +x through the palm as in the grip pose, -z along the straight index finger.
TEST_F(Actions, ThePalmPoseIsARotatedGripPose) {
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction palm = action(set, "palm", XR_ACTION_TYPE_POSE_INPUT);
    ASSERT_EQ(suggest(kSimple, {{palm, "/user/hand/right/input/palm_ext/pose"}}), XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    const XrPosef at_rest = locate(actionSpace(palm)).pose;
    const XrPosef ahead = locate(actionSpace(palm, XR_NULL_PATH, {{0, 0, 0, 1}, {1, 0, -1}})).pose;
    EXPECT_NEAR(ahead.position.x - at_rest.position.x, 1, 1e-6);   // the grip's +x
    EXPECT_NEAR(ahead.position.y - at_rest.position.y, -1, 1e-6);  // the grip's -y
    EXPECT_NEAR(ahead.position.z - at_rest.position.z, 0, 1e-6);
}

TEST_F(Actions, TheTreadmillIsNotASubactionPath) {
    start();
    const XrActionSet set = actionSet("set");
    XrAction result = XR_NULL_HANDLE;
    EXPECT_EQ(tryAction(set, "a", "a", XR_ACTION_TYPE_BOOLEAN_INPUT, {path("/user/treadmill")}, &result),
              XR_ERROR_PATH_UNSUPPORTED);
    for (const char* each : {"/user/head", "/user/gamepad"}) {
        EXPECT_EQ(tryAction(set, each + 6, each, XR_ACTION_TYPE_BOOLEAN_INPUT, {path(each)}, &result),
                  XR_SUCCESS);
    }
}

#ifdef XR_EXT_active_action_set_priority
using Priority = XrActiveActionSetPriorityEXT;
using PrioritiesInfo = XrActiveActionSetPrioritiesEXT;
#else
struct Priority {
    XrActionSet actionSet;
    std::uint32_t priorityOverride;
};
struct PrioritiesInfo {
    XrStructureType type;
    const void* next;
    std::uint32_t actionSetPriorityCount;
    const Priority* actionSetPriorities;
};
#endif

TEST_F(Actions, PriorityOverridesLastForOneSync) {
    startFocused();
    const XrActionSet low = actionSet("low", 1), high = actionSet("high", 2);
    const XrAction low_select = action(low, "low_select", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction high_select = action(high, "high_select", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{low_select, "/user/hand/left/input/select/click"},
                                {high_select, "/user/hand/left/input/select"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({low, high}), XR_SUCCESS);
    const auto syncWith = [&](const std::vector<Priority>& priorities) {
        const PrioritiesInfo given{static_cast<XrStructureType>(1000373000), nullptr,
                                   static_cast<std::uint32_t>(priorities.size()), priorities.data()};
        const XrActiveActionSet active[] = {{low, XR_NULL_PATH}, {high, XR_NULL_PATH}};
        const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, &given, 2, active};
        return xrSyncActions(session_, &info);
    };
    ASSERT_EQ(syncWith({}), XR_SUCCESS);
    EXPECT_TRUE(boolean(high_select).isActive && !boolean(low_select).isActive);
    ASSERT_EQ(syncWith({{low, 3}}), XR_SUCCESS);
    EXPECT_TRUE(!boolean(high_select).isActive && boolean(low_select).isActive);
    ASSERT_EQ(syncWith({{low, 5}, {high, 5}}), XR_SUCCESS);
    EXPECT_TRUE(boolean(high_select).isActive && boolean(low_select).isActive);
    ASSERT_EQ(sync({low, high}), XR_SUCCESS);
    EXPECT_TRUE(boolean(high_select).isActive && !boolean(low_select).isActive);
    EXPECT_EQ(syncWith({{low, 3}, {low, 4}}), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(syncWith({{XR_NULL_HANDLE, 3}}), XR_ERROR_HANDLE_INVALID);
}

}  // namespace
}  // namespace mock_test
