// Reduced versions of the conformance suite's tests that use XR_EXT_conformance_automation.
#include <cmath>
#include <utility>

#include "tests/xr/mock/client/actions_client.h"

namespace mock_test {
namespace {

class Automation : public Actions {
  protected:
    XrResult setActive(const char* user, bool active, const char* profile_path = kSimple) {
        return load<PFN_xrSetInputDeviceActiveEXT>(instance_, "xrSetInputDeviceActiveEXT")(
            session_, path(profile_path), path(user), active ? XR_TRUE : XR_FALSE);
    }
    XrResult set(const char* user, const std::string& component, bool state) {
        return load<PFN_xrSetInputDeviceStateBoolEXT>(instance_, "xrSetInputDeviceStateBoolEXT")(
            session_, path(user), path((user + component).c_str()), state ? XR_TRUE : XR_FALSE);
    }
    XrResult set(const char* user, const std::string& component, float state) {
        return load<PFN_xrSetInputDeviceStateFloatEXT>(instance_, "xrSetInputDeviceStateFloatEXT")(
            session_, path(user), path((user + component).c_str()), state);
    }
    XrResult set(const char* user, const std::string& component, XrVector2f state) {
        return load<PFN_xrSetInputDeviceStateVector2fEXT>(instance_, "xrSetInputDeviceStateVector2fEXT")(
            session_, path(user), path((user + component).c_str()), state);
    }
    XrResult place(const char* user, const std::string& component, XrSpace space, XrPosef pose) {
        return load<PFN_xrSetInputDeviceLocationEXT>(instance_, "xrSetInputDeviceLocationEXT")(
            session_, path(user), path((user + component).c_str()), space, pose);
    }
};

TEST_F(Automation, TakesControlFromTheScenario) {
    startFocused();
    const XrActionSet actions = actionSet("set");
    const XrAction press =
        action(actions, "press", XR_ACTION_TYPE_BOOLEAN_INPUT, {path(kLeft), path(kRight)});
    ASSERT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select/click"},
                                {press, "/user/hand/right/input/select/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({actions}), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press, path(kRight)).isActive);
    ASSERT_EQ(setActive(kLeft, true), XR_SUCCESS);
    EXPECT_TRUE(boolean(press, path(kRight)).isActive);  // until the next xrSyncActions
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_FALSE(boolean(press, path(kRight)).isActive);
    EXPECT_TRUE(boolean(press, path(kLeft)).isActive);
    EXPECT_FALSE(boolean(press, path(kLeft)).currentState);
    EXPECT_EQ(profile(kLeft), kSimple);
    EXPECT_EQ(profile(kRight), "");

    ASSERT_EQ(set(kLeft, "/input/select/click", true), XR_SUCCESS);
    frame();
    EXPECT_FALSE(boolean(press).currentState);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    const auto pressed = boolean(press);
    EXPECT_TRUE(pressed.currentState && pressed.changedSinceLastSync);
    EXPECT_GT(pressed.lastChangeTime, 0);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).currentState);
    EXPECT_FALSE(boolean(press).changedSinceLastSync);
    EXPECT_EQ(boolean(press).lastChangeTime, pressed.lastChangeTime);

    ASSERT_EQ(setActive(kLeft, false), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).currentState);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    const auto gone = boolean(press);
    EXPECT_FALSE(gone.isActive || gone.currentState || gone.changedSinceLastSync);
    EXPECT_EQ(gone.lastChangeTime, 0);
}

TEST_F(Automation, TheActivatedProfileIsCurrentWhateverTheOrderOfSuggestions) {
    startFocused();
    const XrActionSet actions = actionSet("set");
    const XrAction press = action(actions, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    constexpr char kXbox[] = "/interaction_profiles/microsoft/xbox_controller";
    constexpr char kVivePro[] = "/interaction_profiles/htc/vive_pro";
    ASSERT_EQ(suggest(kTouch, {{press, "/user/hand/left/input/x/click"}}), XR_SUCCESS);
    ASSERT_EQ(suggest(kXbox, {{press, "/user/gamepad/input/a/click"}}), XR_SUCCESS);
    ASSERT_EQ(suggest(kVivePro, {{press, "/user/head/input/volume_up/click"}}), XR_SUCCESS);
    ASSERT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select"}}), XR_SUCCESS);
    ASSERT_EQ(attach({actions}), XR_SUCCESS);
    ASSERT_EQ(setActive(kLeft, true, kTouch), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    ASSERT_TRUE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());
    EXPECT_EQ(profile(kLeft), kTouch);
    ASSERT_EQ(set(kLeft, "/input/x/click", true), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).currentState);
    EXPECT_FALSE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());

    ASSERT_EQ(setActive(kLeft, true, kSimple), XR_SUCCESS);
    ASSERT_EQ(setActive("/user/gamepad", true, kXbox), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), kTouch);  // profiles change only in xrSyncActions
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());
    EXPECT_FALSE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());  // a single event
    EXPECT_EQ(profile(kLeft), kSimple);
    EXPECT_EQ(profile("/user/gamepad"), kXbox);
    EXPECT_EQ(profile("/user/head"), "");
    EXPECT_FALSE(boolean(press).currentState);
    ASSERT_EQ(set("/user/gamepad", "/input/a/click", true), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).currentState);

    // A device without suggested bindings for its profile delivers no input.
    ASSERT_EQ(setActive(kLeft, true, "/interaction_profiles/valve/index_controller"), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), "");
}

TEST_F(Automation, RefusesForeignPaths) {
    startFocused();
    EXPECT_EQ(setActive("/user/hand", true), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(setActive("/user/gamepad", true), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(setActive(kLeft, true, "/interaction_profiles/khr/other"), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(set(kLeft, "/input/select/clack", true), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(set(kLeft, "/output/haptic", true), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(set(kLeft, "/input/trigger", XrVector2f{0, 0}), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(set(kLeft, "/input/trigger/value", std::nanf("")), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(place(kLeft, "/input/select/click", stage_, kIdentity), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(place(kLeft, "/input/elbow/pose", stage_, kIdentity), XR_ERROR_PATH_UNSUPPORTED);
    EXPECT_EQ(place(kLeft, "/input/grip/pose", stage_, {{0, 0, 0, 0}, {}}), XR_ERROR_POSE_INVALID);
    EXPECT_EQ(place(kLeft, "/input/grip/pose", XR_NULL_HANDLE, kIdentity), XR_ERROR_HANDLE_INVALID);
    const auto set_active = load<PFN_xrSetInputDeviceActiveEXT>(instance_, "xrSetInputDeviceActiveEXT");
    EXPECT_EQ(set_active(session_, XR_NULL_PATH, path(kLeft), XR_TRUE), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(set_active(session_, path(kSimple), 0x1234, XR_TRUE), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(set_active(XR_NULL_HANDLE, path(kSimple), path(kLeft), XR_TRUE), XR_ERROR_HANDLE_INVALID);
}

// An action bound to all sources of a type combines them: logical or, largest value, longest vector.
TEST_F(Automation, SeveralSourcesAreCombined) {
    startFocused();
    constexpr char kIndex[] = "/interaction_profiles/valve/index_controller";
    const XrActionSet actions = actionSet("set");
    const XrAction any = action(actions, "any", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction largest = action(actions, "largest", XR_ACTION_TYPE_FLOAT_INPUT);
    const XrAction longest = action(actions, "longest", XR_ACTION_TYPE_VECTOR2F_INPUT);
    const XrAction stick = action(actions, "stick", XR_ACTION_TYPE_VECTOR2F_INPUT);
    const XrAction x = action(actions, "x", XR_ACTION_TYPE_FLOAT_INPUT);
    const XrAction y = action(actions, "y", XR_ACTION_TYPE_FLOAT_INPUT);
    ASSERT_EQ(suggest(kIndex, {{any, "/user/hand/left/input/a/click"},
                               {any, "/user/hand/left/input/b/touch"},
                               {largest, "/user/hand/left/input/trigger/value"},
                               {largest, "/user/hand/left/input/squeeze"},
                               {largest, "/user/hand/left/input/thumbstick/x"},
                               {longest, "/user/hand/left/input/thumbstick"},
                               {longest, "/user/hand/left/input/trackpad"},
                               {stick, "/user/hand/left/input/thumbstick"},
                               {x, "/user/hand/left/input/thumbstick/x"},
                               {y, "/user/hand/left/input/thumbstick/y"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({actions}), XR_SUCCESS);
    ASSERT_EQ(setActive(kLeft, true, kIndex), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(any != XR_NULL_HANDLE && boolean(any).isActive && number(largest).isActive);

    set(kLeft, "/input/b/touch", true);
    set(kLeft, "/input/trigger/value", 0.25F);
    set(kLeft, "/input/squeeze/value", 0.5F);
    set(kLeft, "/input/thumbstick", XrVector2f{-0.75F, 0});
    set(kLeft, "/input/trackpad", XrVector2f{0.5F, 0.625F});
    frame();
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(any).currentState);
    EXPECT_EQ(number(largest).currentState, -0.75F);
    EXPECT_EQ(vector(longest).currentState.x, 0.5F);
    EXPECT_EQ(vector(longest).currentState.y, 0.625F);
    EXPECT_EQ(number(x).currentState, vector(stick).currentState.x);
    EXPECT_TRUE(number(x).changedSinceLastSync && vector(stick).changedSinceLastSync);
    EXPECT_FALSE(number(y).changedSinceLastSync);
    EXPECT_EQ(number(x).lastChangeTime, vector(stick).lastChangeTime);

    set(kLeft, "/input/thumbstick", XrVector2f{-0.25F, 1});
    frame();
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_EQ(number(largest).currentState, 0.5F);
    EXPECT_TRUE(number(largest).changedSinceLastSync);
    EXPECT_EQ(vector(longest).currentState.y, 1.0F);
    EXPECT_EQ(std::max(number(x).lastChangeTime, number(y).lastChangeTime), vector(stick).lastChangeTime);

    set(kLeft, "/input/b/touch", false);
    set(kLeft, "/input/a/click", true);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(boolean(any).currentState);
    EXPECT_FALSE(boolean(any).changedSinceLastSync);  // another source contributes the same value
    set(kLeft, "/input/trigger/value", 7.0F);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_EQ(number(largest).currentState, 1.0F);
}

TEST_F(Automation, ValuesAreConvertedWhereTheSpecificationSaysSo) {
    startFocused();
    const XrActionSet actions = actionSet("set");
    const auto make = [&](const char* name, XrActionType type) { return action(actions, name, type); };
    const XrAction trigger = make("trigger", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction click = make("click", XR_ACTION_TYPE_FLOAT_INPUT);
    const XrAction stick_pressed = make("stick_pressed", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction squeeze_parent = make("squeeze_parent", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction vector_of_click = make("vector_of_click", XR_ACTION_TYPE_VECTOR2F_INPUT);
    const XrAction boolean_of_pose = make("boolean_of_pose", XR_ACTION_TYPE_BOOLEAN_INPUT);
    const XrAction pose_of_click = make("pose_of_click", XR_ACTION_TYPE_POSE_INPUT);
    const XrAction pose_parent = make("pose_parent", XR_ACTION_TYPE_POSE_INPUT);
    ASSERT_EQ(suggest(kTouch, {{trigger, "/user/hand/left/input/trigger/value"},
                               {click, "/user/hand/left/input/x/click"},
                               {stick_pressed, "/user/hand/left/input/thumbstick"},
                               {squeeze_parent, "/user/hand/left/input/squeeze"},
                               {vector_of_click, "/user/hand/left/input/x/click"},
                               {boolean_of_pose, "/user/hand/left/input/grip/pose"},
                               {pose_of_click, "/user/hand/left/input/x/click"},
                               {pose_parent, "/user/hand/left/input/aim"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({actions}), XR_SUCCESS);
    ASSERT_EQ(setActive(kLeft, true, kTouch), XR_SUCCESS);
    set(kLeft, "/input/x/click", true);
    set(kLeft, "/input/thumbstick/click", true);
    set(kLeft, "/input/squeeze/value", 0.9F);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_EQ(number(click).currentState, 1.0F);
    EXPECT_TRUE(boolean(stick_pressed).currentState);
    EXPECT_TRUE(boolean(squeeze_parent).currentState);
    EXPECT_FALSE(vector(vector_of_click).isActive);
    EXPECT_FALSE(boolean(boolean_of_pose).isActive);
    EXPECT_FALSE(poseActive(pose_of_click));
    EXPECT_TRUE(poseActive(pose_parent));
    // The threshold has hysteresis: pressed at 0.5, released below 0.4.
    const std::pair<float, bool> steps[] = {{0.45F, false}, {0.5F, true},   {0.45F, true},
                                            {0.4F, true},   {0.39F, false}, {0.45F, false}};
    for (const auto& [value, pressed] : steps) {
        set(kLeft, "/input/trigger/value", value);
        ASSERT_EQ(sync({actions}), XR_SUCCESS);
        EXPECT_EQ(boolean(trigger).currentState, pressed) << value;
    }
}

// "A pose action picks one device and sticks with it". The order of events is that of the conformance
// suite.
TEST_F(Automation, APoseActionStaysWithItsDevice) {
    startFocused();
    const XrPath left = path(kLeft), right = path(kRight);
    const XrActionSet actions = actionSet("set"), others = actionSet("others");
    const XrAction grip = action(actions, "grip", XR_ACTION_TYPE_POSE_INPUT, {left, right});
    const XrAction press = action(others, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{grip, "/user/hand/left/input/grip/pose"},
                                {grip, "/user/hand/right/input/grip/pose"},
                                {press, "/user/hand/left/input/select/click"}}),
              XR_SUCCESS);
    const XrSpace early = actionSpace(grip);
    ASSERT_EQ(attach({actions, others}), XR_SUCCESS);
    const XrSpace both = actionSpace(grip), left_space = actionSpace(grip, left),
                  right_space = actionSpace(grip, right);
    const auto found = [&](XrSpace space) { return locate(space).locationFlags != 0; };
    ASSERT_EQ(setActive(kLeft, true), XR_SUCCESS);
    ASSERT_EQ(setActive(kRight, true), XR_SUCCESS);
    ASSERT_EQ(sync({others}), XR_SUCCESS);
    EXPECT_FALSE(found(left_space));
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(found(both) && found(early) && found(left_space) && found(right_space));
    EXPECT_EQ(locate(both).pose.position.x, locate(left_space).pose.position.x);
    EXPECT_NE(locate(both).pose.position.x, locate(right_space).pose.position.x);

    // Before xrSyncActions, the pose is lost with the device but the action state stays.
    ASSERT_EQ(setActive(kLeft, false), XR_SUCCESS);
    EXPECT_FALSE(found(left_space) || found(both) || found(early));
    EXPECT_TRUE(poseActive(grip, left) && poseActive(grip));
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_FALSE(found(both));
    EXPECT_FALSE(poseActive(grip));
    EXPECT_TRUE(poseActive(grip, right) && found(right_space));

    // The pose does not return before xrSyncActions either.
    ASSERT_EQ(setActive(kLeft, true), XR_SUCCESS);
    EXPECT_FALSE(found(left_space) || poseActive(grip, left));
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(found(left_space) && found(both));
    ASSERT_EQ(xrDestroyAction(grip), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    EXPECT_TRUE(found(left_space) && found(both) && found(right_space));
}

TEST_F(Automation, LocationsAreSetInAnySpace) {
    setScript(R"({"version": 2, "controllers": {"left": {
        "grip_from_aim": {"position": [0, 0, -0.5]}, "poses": [{"t_s": 0, "position": [0, 0, 0]}]}}})");
    startFocused();
    const XrActionSet actions = actionSet("set");
    const XrAction grip = action(actions, "grip", XR_ACTION_TYPE_POSE_INPUT);
    const XrAction aim = action(actions, "aim", XR_ACTION_TYPE_POSE_INPUT);
    ASSERT_EQ(suggest(kSimple,
                      {{grip, "/user/hand/left/input/grip/pose"}, {aim, "/user/hand/left/input/aim/pose"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({actions}), XR_SUCCESS);
    const XrSpace grip_space = actionSpace(grip), aim_space = actionSpace(aim);
    ASSERT_EQ(setActive(kLeft, true), XR_SUCCESS);
    const XrSpace shifted = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE, {{0, 0, 0, 1}, {1, 2, 3}});
    ASSERT_EQ(place(kLeft, "/input/grip/pose", shifted, {{0, 1, 0, 0}, {0.5F, 0, 0}}), XR_SUCCESS);
    ASSERT_EQ(sync({actions}), XR_SUCCESS);
    const XrPosef pose = locate(grip_space).pose;
    EXPECT_FLOAT_EQ(pose.position.x, 1.5F);
    EXPECT_FLOAT_EQ(pose.position.y, 2);
    EXPECT_FLOAT_EQ(pose.orientation.y, 1);
    // The aim pose is half a metre in front of the grip, and the grip is turned by 180 degrees.
    EXPECT_FLOAT_EQ(locate(aim_space).pose.position.z, 3.5F);
    ASSERT_EQ(place(kLeft, "/input/aim/pose", stage_, {{0, 0, 0, 1}, {7, 0, 0}}), XR_SUCCESS);
    EXPECT_FLOAT_EQ(locate(aim_space).pose.position.x, 7);
    EXPECT_FLOAT_EQ(locate(grip_space).pose.position.x, 1.5F);
}

}  // namespace
}  // namespace mock_test
