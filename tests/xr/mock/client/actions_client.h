// A client with action sets, actions, suggested bindings and action states.
#pragma once

#include <cstring>

#include "tests/xr/mock/client/client.h"

namespace mock_test {

constexpr char kLeft[] = "/user/hand/left";
constexpr char kRight[] = "/user/hand/right";
constexpr char kSimple[] = "/interaction_profiles/khr/simple_controller";
constexpr char kTouch[] = "/interaction_profiles/oculus/touch_controller";

class Actions : public MockTest {
  protected:
    XrResult tryActionSet(const char* name, const char* localized, XrActionSet* set,
                          std::uint32_t priority = 0) {
        auto info = makeStruct<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
        std::strcpy(info.actionSetName, name);
        std::strcpy(info.localizedActionSetName, localized);
        info.priority = priority;
        return xrCreateActionSet(instance_, &info, set);
    }
    XrActionSet actionSet(const char* name, std::uint32_t priority = 0) {
        XrActionSet set = XR_NULL_HANDLE;
        EXPECT_EQ(tryActionSet(name, name, &set, priority), XR_SUCCESS);
        return set;
    }
    XrResult tryAction(XrActionSet set, const char* name, const char* localized, XrActionType type,
                       const std::vector<XrPath>& subactions, XrAction* action) {
        auto info = makeStruct<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
        std::strcpy(info.actionName, name);
        std::strcpy(info.localizedActionName, localized);
        info.actionType = type;
        info.countSubactionPaths = static_cast<std::uint32_t>(subactions.size());
        info.subactionPaths = subactions.data();
        return xrCreateAction(set, &info, action);
    }
    XrAction action(XrActionSet set, const char* name, XrActionType type,
                    const std::vector<XrPath>& subactions = {}) {
        XrAction result = XR_NULL_HANDLE;
        EXPECT_EQ(tryAction(set, name, name, type, subactions, &result), XR_SUCCESS);
        return result;
    }
    struct Suggestion {
        XrAction action;
        const char* path;
    };
    XrResult suggest(const char* profile, const std::vector<Suggestion>& suggestions) {
        std::vector<XrActionSuggestedBinding> bindings;
        for (const Suggestion& each : suggestions)
            bindings.push_back({each.action, path(each.path)});
        const XrInteractionProfileSuggestedBinding info{
            XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, path(profile),
            static_cast<std::uint32_t>(bindings.size()), bindings.data()};
        return xrSuggestInteractionProfileBindings(instance_, &info);
    }
    XrResult attach(const std::vector<XrActionSet>& sets) {
        const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr,
                                                 static_cast<std::uint32_t>(sets.size()), sets.data()};
        return xrAttachSessionActionSets(session_, &info);
    }
    XrResult sync(const std::vector<XrActionSet>& sets, XrPath subaction = XR_NULL_PATH) {
        std::vector<XrActiveActionSet> active;
        for (XrActionSet set : sets)
            active.push_back({set, subaction});
        const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr,
                                     static_cast<std::uint32_t>(active.size()), active.data()};
        return xrSyncActions(session_, &info);
    }
    XrActionStateGetInfo of(XrAction action, XrPath subaction = XR_NULL_PATH) {
        return {XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
    }
    XrActionStateVector2f vector(XrAction action, XrPath subaction = XR_NULL_PATH) {
        auto state = makeStruct<XrActionStateVector2f>(XR_TYPE_ACTION_STATE_VECTOR2F);
        const auto info = of(action, subaction);
        EXPECT_EQ(xrGetActionStateVector2f(session_, &info, &state), XR_SUCCESS);
        return state;
    }
    bool poseActive(XrAction action, XrPath subaction = XR_NULL_PATH) {
        auto state = makeStruct<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE);
        const auto info = of(action, subaction);
        EXPECT_EQ(xrGetActionStatePose(session_, &info, &state), XR_SUCCESS);
        return state.isActive == XR_TRUE;
    }
    // The current interaction profile, or empty if there is none.
    std::string profile(const char* user_path) {
        auto state = makeStruct<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
        EXPECT_EQ(xrGetCurrentInteractionProfile(session_, path(user_path), &state), XR_SUCCESS);
        if (state.interactionProfile == XR_NULL_PATH) return {};
        char text[XR_MAX_PATH_LENGTH];
        std::uint32_t length = 0;
        EXPECT_EQ(xrPathToString(instance_, state.interactionProfile, sizeof text, &length, text),
                  XR_SUCCESS);
        return text;
    }
    XrSpace actionSpace(XrAction action, XrPath subaction = XR_NULL_PATH, XrPosef pose = kIdentity) {
        const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, action, subaction,
                                           pose};
        XrSpace space = XR_NULL_HANDLE;
        EXPECT_EQ(xrCreateActionSpace(session_, &info, &space), XR_SUCCESS);
        return space;
    }
    XrSpaceLocation locate(XrSpace space, XrTime time = 1'000'000'000) {
        return MockTest::locate(space, stage_, time);
    }
    XrActionStateBoolean boolean(XrAction action, XrPath subaction = XR_NULL_PATH) {
        auto state = makeStruct<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
        const auto info = of(action, subaction);
        EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_SUCCESS);
        return state;
    }
    XrActionStateFloat number(XrAction action, XrPath subaction = XR_NULL_PATH) {
        auto state = makeStruct<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
        const auto info = of(action, subaction);
        EXPECT_EQ(xrGetActionStateFloat(session_, &info, &state), XR_SUCCESS);
        return state;
    }
};

}  // namespace mock_test
