#include "xr/input.h"

namespace stylet::xr {
namespace {

struct Profile {
    const char* name;
    const char* select;
    std::array<const char*, 2> menu;  // left, right
};

// Every profile here has /input/grip/pose and /output/haptic. A trigger bound to a boolean action is
// thresholded by the runtime.
constexpr Profile kProfiles[] = {
    {"/interaction_profiles/khr/simple_controller",
     "/input/select/click",
     {"/input/menu/click", "/input/menu/click"}},
    {"/interaction_profiles/oculus/touch_controller",
     "/input/trigger/value",
     {"/input/menu/click", "/input/b/click"}},
};
constexpr std::array<const char*, 2> kSides{"/user/hand/left", "/user/hand/right"};

XrPath pathOf(XrInstance instance, const std::string& text) {
    XrPath path = XR_NULL_PATH;
    check(xrStringToPath(instance, text.c_str(), &path), "xrStringToPath", text);
    return path;
}

XrAction makeAction(XrActionSet set, XrActionType type, const char* name, const char* shown,
                    const std::array<XrPath, 2>& sides) {
    auto info = typed<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    std::string(name).copy(info.actionName, XR_MAX_ACTION_NAME_SIZE - 1);
    std::string(shown).copy(info.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE - 1);
    info.actionType = type;
    info.countSubactionPaths = std::uint32_t(sides.size());
    info.subactionPaths = sides.data();
    XrAction action = XR_NULL_HANDLE;
    check(xrCreateAction(set, &info, &action), "xrCreateAction", "the runtime refuses a controller action");
    return action;
}

}  // namespace

void Input::create(XrInstance instance, XrSession session, std::vector<std::string>& notes) {
    auto info = typed<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::string("trainer").copy(info.actionSetName, XR_MAX_ACTION_SET_NAME_SIZE - 1);
    std::string("Trainer").copy(info.localizedActionSetName, XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE - 1);
    check(xrCreateActionSet(instance, &info, set_.out()), "xrCreateActionSet",
          "the runtime refuses controller actions");
    for (std::size_t side = 0; side < 2; ++side)
        sides_[side] = pathOf(instance, kSides[side]);
    actions_.grip = makeAction(set_.get(), XR_ACTION_TYPE_POSE_INPUT, "grip", "Hand", sides_);
    actions_.select = makeAction(set_.get(), XR_ACTION_TYPE_BOOLEAN_INPUT, "select", "Select", sides_);
    actions_.menu = makeAction(set_.get(), XR_ACTION_TYPE_BOOLEAN_INPUT, "menu", "Menu", sides_);
    actions_.haptic = makeAction(set_.get(), XR_ACTION_TYPE_VIBRATION_OUTPUT, "haptic", "Vibration", sides_);
    suggest(instance, notes);

    auto attach = typed<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    const XrActionSet set = set_.get();
    attach.countActionSets = 1;
    attach.actionSets = &set;
    check(xrAttachSessionActionSets(session, &attach), "xrAttachSessionActionSets",
          "the runtime refuses controller actions");
    for (std::size_t side = 0; side < 2; ++side) {
        auto space = typed<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
        space.action = actions_.grip;
        space.subactionPath = sides_[side];
        space.poseInActionSpace = kIdentityPose;
        check(xrCreateActionSpace(session, &space, grips_[side].out()), "xrCreateActionSpace",
              "the runtime does not track controllers");
    }
}

void Input::suggest(XrInstance instance, std::vector<std::string>& notes) {
    for (const Profile& profile : kProfiles) {
        std::vector<XrActionSuggestedBinding> bindings;
        for (std::size_t side = 0; side < 2; ++side) {
            const std::string hand = kSides[side];
            bindings.push_back({actions_.grip, pathOf(instance, hand + "/input/grip/pose")});
            bindings.push_back({actions_.select, pathOf(instance, hand + profile.select)});
            bindings.push_back({actions_.menu, pathOf(instance, hand + profile.menu[side])});
            bindings.push_back({actions_.haptic, pathOf(instance, hand + "/output/haptic")});
        }
        auto suggestion =
            typed<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
        suggestion.interactionProfile = pathOf(instance, profile.name);
        suggestion.countSuggestedBindings = std::uint32_t(bindings.size());
        suggestion.suggestedBindings = bindings.data();
        const XrResult result = xrSuggestInteractionProfileBindings(instance, &suggestion);
        if (XR_FAILED(result))
            notes.push_back("xrSuggestInteractionProfileBindings: " + resultName(result) +
                            ": the runtime takes no " + profile.name + " bindings");
    }
}

XrResult Input::sync(XrSession session, XrSpace stage, XrTime time) {
    const XrActiveActionSet active{set_.get(), XR_NULL_PATH};
    auto info = typed<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
    info.countActiveActionSets = 1;
    info.activeActionSets = &active;
    const XrResult synced = xrSyncActions(session, &info);
    hands_ = {};
    if (XR_FAILED(synced) || synced == XR_SESSION_NOT_FOCUSED) return synced;
    for (int side = 0; side < 2; ++side)
        if (const XrResult read = readHand(session, stage, time, side); XR_FAILED(read)) return read;
    return synced;
}

XrResult Input::readHand(XrSession session, XrSpace stage, XrTime time, int side) {
    auto get = typed<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    get.subactionPath = sides_[std::size_t(side)];
    auto grip = typed<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE);
    auto select = typed<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN), menu = select;
    get.action = actions_.grip;
    if (const XrResult r = xrGetActionStatePose(session, &get, &grip); XR_FAILED(r)) return r;
    get.action = actions_.select;
    if (const XrResult r = xrGetActionStateBoolean(session, &get, &select); XR_FAILED(r)) return r;
    get.action = actions_.menu;
    if (const XrResult r = xrGetActionStateBoolean(session, &get, &menu); XR_FAILED(r)) return r;

    Hand& hand = hands_[std::size_t(side)];
    hand.active = grip.isActive;
    hand.select = select.isActive && select.currentState;
    hand.menu = menu.isActive && menu.currentState;
    if (!grip.isActive) return XR_SUCCESS;
    auto location = typed<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    const XrResult located = xrLocateSpace(grips_[std::size_t(side)].get(), stage, time, &location);
    constexpr XrSpaceLocationFlags kWhole =
        XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT;
    if (XR_SUCCEEDED(located) && (location.locationFlags & kWhole) == kWhole)
        hand.stage_from_grip = poseOf(location.pose);
    return located;
}

XrResult Input::pulse(XrSession session, int side, float amplitude, XrDuration duration_ns) {
    auto info = typed<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
    info.action = actions_.haptic;
    info.subactionPath = sides_[std::size_t(side)];
    auto vibration = typed<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
    vibration.duration = duration_ns;
    vibration.frequency = XR_FREQUENCY_UNSPECIFIED;
    vibration.amplitude = amplitude;
    return xrApplyHapticFeedback(session, &info, reinterpret_cast<const XrHapticBaseHeader*>(&vibration));
}

}  // namespace stylet::xr
