#include "xr/input.h"

#include <algorithm>

namespace stylet::xr {
namespace {

constexpr const char* kNoActions = "the runtime refuses controller actions";

XrAction makeAction(XrActionSet set, XrActionType type, const char* name, const char* shown,
                    const std::array<XrPath, 2>& sides) {
    auto info = makeStruct<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    std::string(name).copy(info.actionName, XR_MAX_ACTION_NAME_SIZE - 1);
    std::string(shown).copy(info.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE - 1);
    info.actionType = type;
    info.countSubactionPaths = std::uint32_t(sides.size());
    info.subactionPaths = sides.data();
    XrAction action = XR_NULL_HANDLE;
    check(xrCreateAction(set, &info, &action), "xrCreateAction", kNoActions);
    return action;
}

void makeActionSpace(XrSession session, XrAction action, XrPath side, Owned<XrSpace, xrDestroySpace>& space) {
    auto info = makeStruct<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
    info.action = action;
    info.subactionPath = side;
    info.poseInActionSpace = kIdentityPose;
    check(xrCreateActionSpace(session, &info, space.out()), "xrCreateActionSpace",
          "the runtime tracks no controllers");
}

XrResult locate(XrSpace space, XrSpace stage, XrTime time, std::optional<Pose>& pose,
                XrSpaceLocationFlags needed = kWholePose) {
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    const XrResult result = xrLocateSpace(space, stage, time, &location);
    pose = XR_SUCCEEDED(result) ? wholePose(location.locationFlags, location.pose, needed) : std::nullopt;
    return result;
}

}  // namespace

void Input::create(const Instance& instance, XrSession session, std::vector<std::string>& notes) {
    createActions(instance);
    suggestBindings(instance, actions_, notes);
    auto attach = makeStruct<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    const XrActionSet set = set_.get();
    attach.countActionSets = 1;
    attach.actionSets = &set;
    check(xrAttachSessionActionSets(session, &attach), "xrAttachSessionActionSets", kNoActions);
    for (std::size_t side = 0; side < 2; ++side) {
        makeActionSpace(session, actions_.grip, sides_[side], grips_[side]);
        makeActionSpace(session, actions_.aim, sides_[side], aims_[side]);
    }
    bare_hands_.create(instance, session);
}

void Input::createActions(const Instance& instance) {
    auto info = makeStruct<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::string("trainer").copy(info.actionSetName, XR_MAX_ACTION_SET_NAME_SIZE - 1);
    std::string("Trainer").copy(info.localizedActionSetName, XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE - 1);
    check(xrCreateActionSet(instance.handle.get(), &info, set_.out()), "xrCreateActionSet", kNoActions);
    for (std::size_t side = 0; side < 2; ++side)
        sides_[side] = toXrPath(instance.handle.get(), kSides[side]);
    const auto make = [&](XrActionType type, const char* name, const char* shown) {
        return makeAction(set_.get(), type, name, shown, sides_);
    };
    actions_.grip = make(XR_ACTION_TYPE_POSE_INPUT, "grip", "Hand");
    actions_.aim = make(XR_ACTION_TYPE_POSE_INPUT, "aim", "Pointing");
    actions_.select = make(XR_ACTION_TYPE_BOOLEAN_INPUT, "select", "Select");
    actions_.menu = make(XR_ACTION_TYPE_BOOLEAN_INPUT, "menu", "Menu");
    actions_.squeeze = make(XR_ACTION_TYPE_FLOAT_INPUT, "squeeze", "Squeeze");
    actions_.thumbstick = make(XR_ACTION_TYPE_VECTOR2F_INPUT, "thumbstick", "Thumbstick");
    actions_.haptic = make(XR_ACTION_TYPE_VIBRATION_OUTPUT, "haptic", "Vibration");
}

XrResult Input::sync(XrSession session, XrSpace stage, XrTime time) {
    const XrActiveActionSet active{set_.get(), XR_NULL_PATH};
    auto info = makeStruct<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
    info.countActiveActionSets = 1;
    info.activeActionSets = &active;
    const XrResult synced = xrSyncActions(session, &info);
    hands_ = {};
    if (XR_FAILED(synced) || synced == XR_SESSION_NOT_FOCUSED) return synced;
    XrResult result = synced;
    for (int side = 0; side < 2; ++side) {
        const XrResult read = readHand(session, stage, time, side);
        if (XR_FAILED(read)) return read;
        if (read != XR_SUCCESS) result = read;
    }
    return result;
}

XrResult Input::readHand(XrSession session, XrSpace stage, XrTime time, int side) {
    auto get = makeStruct<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
    get.subactionPath = sides_[std::size_t(side)];
    auto grip = makeStruct<XrActionStatePose>(XR_TYPE_ACTION_STATE_POSE), aim = grip;
    auto select = makeStruct<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN), menu = select;
    auto squeeze = makeStruct<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
    auto stick = makeStruct<XrActionStateVector2f>(XR_TYPE_ACTION_STATE_VECTOR2F);
    XrResult result = XR_SUCCESS;
    const auto read = [&](auto call, XrAction action, auto& state) {
        if (XR_FAILED(result)) return;
        get.action = action;
        const XrResult one = call(session, &get, &state);
        if (one != XR_SUCCESS) result = one;
    };
    read(xrGetActionStatePose, actions_.grip, grip);
    read(xrGetActionStatePose, actions_.aim, aim);
    read(xrGetActionStateBoolean, actions_.select, select);
    read(xrGetActionStateBoolean, actions_.menu, menu);
    read(xrGetActionStateFloat, actions_.squeeze, squeeze);
    read(xrGetActionStateVector2f, actions_.thumbstick, stick);
    if (XR_FAILED(result)) return result;

    Hand& hand = hands_[std::size_t(side)];
    hand.active = grip.isActive;
    is_bare_[std::size_t(side)] = !grip.isActive;
    if (!grip.isActive) return bare_hands_.read(stage, time, side, hand);
    hand.select = select.isActive && select.currentState;
    hand.menu = menu.isActive && menu.currentState;
    if (squeeze.isActive) hand.squeeze = std::clamp(squeeze.currentState, 0.0f, 1.0f);
    if (stick.isActive) hand.thumbstick = {stick.currentState.x, stick.currentState.y};
    const XrResult located = locate(grips_[std::size_t(side)].get(), stage, time, hand.stage_from_grip);
    if (XR_FAILED(located) || !aim.isActive) return located;
    return locate(aims_[std::size_t(side)].get(), stage, time, hand.stage_from_aim);
}

XrResult Input::readProfiles(const Instance& instance, XrSession session,
                             std::array<std::string, 2>& profiles) const {
    XrResult result = XR_SUCCESS;
    for (std::size_t side = 0; side < 2; ++side) {
        profiles[side].clear();
        auto state = makeStruct<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
        result = xrGetCurrentInteractionProfile(session, sides_[side], &state);
        if (XR_FAILED(result)) return result;
        if (state.interactionProfile == XR_NULL_PATH) continue;
        std::array<char, XR_MAX_PATH_LENGTH> text{};
        std::uint32_t length = 0;
        const XrResult named = xrPathToString(instance.handle.get(), state.interactionProfile,
                                              std::uint32_t(text.size()), &length, text.data());
        if (XR_FAILED(named)) return named;
        profiles[side] = text.data();
    }
    return result;
}

std::optional<Pose> Input::gripAt(XrSpace stage, XrTime time, int side) const {
    if (is_bare_[std::size_t(side)]) return bare_hands_.gripAt(stage, time, side);
    std::optional<Pose> pose;
    locate(grips_[std::size_t(side)].get(), stage, time, pose, kTracked);
    return pose;
}

XrResult Input::pulse(XrSession session, int side, float amplitude, XrDuration duration_ns) {
    auto info = makeStruct<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
    info.action = actions_.haptic;
    info.subactionPath = sides_[std::size_t(side)];
    auto vibration = makeStruct<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
    vibration.duration = duration_ns;
    vibration.frequency = XR_FREQUENCY_UNSPECIFIED;
    vibration.amplitude = amplitude;
    return xrApplyHapticFeedback(session, &info, reinterpret_cast<const XrHapticBaseHeader*>(&vibration));
}

}  // namespace stylet::xr
