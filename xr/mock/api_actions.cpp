#include <algorithm>
#include <array>
#include <memory>
#include <set>

#include "api.h"
#include "director.h"
#include "localized_names.h"
#include "objects.h"
#include "profiles.h"
#include "two_call.h"
#include "verify.h"

namespace xrmock {

namespace {

template <std::size_t kNameSize, std::size_t kLocalizedSize>
void checkNames(const char (&name)[kNameSize], const char (&localized_name)[kLocalizedSize]) {
    require(isTerminated(name) && name[0] != '\0', XR_ERROR_NAME_INVALID,
            "the name is empty or not terminated");
    require(isWellFormedLevel(name), XR_ERROR_PATH_FORMAT_INVALID,
            "the name is no well-formed level of a path");
    require(isTerminated(localized_name) && localized_name[0] != '\0', XR_ERROR_LOCALIZED_NAME_INVALID,
            "the localized name is empty or not terminated");
}

// Names are unique among the live children of a parent.
template <class T>
void checkUnique(const Object& parent, const char* name, const char* localized_name) {
    for (const Object* child : parent.children) {
        if (child->type != T::kType) continue;
        const auto& sibling = static_cast<const T&>(*child);
        require(sibling.name != name, XR_ERROR_NAME_DUPLICATED, "the name is taken");
        require(sibling.localized_name != localized_name, XR_ERROR_LOCALIZED_NAME_DUPLICATED,
                "the localized name is taken");
    }
}

void requireUserPath(const Instance& instance, XrPath path) {
    require(isTopLevelUserPath(pathString(instance, path)), XR_ERROR_PATH_UNSUPPORTED,
            "not a top level user path");
}

// Which hand a path like "/user/hand/left" means; -1 for other users.
int handOf(const std::string& user_path) {
    if (user_path == "/user/hand/left") return 0;
    return user_path == "/user/hand/right" ? 1 : -1;
}

std::vector<Binding> bindingsOf(Instance& instance, const Action& action, const Profile& profile) {
    std::vector<Binding> bindings;
    for (const SuggestedBinding& suggested : instance.suggestions[profile.path]) {
        if (suggested.action != action.handle) continue;
        BindingPath path;
        splitBindingPath(*instance.paths.toString(suggested.path), path);
        const int hand = handOf(path.user_path);
        if (hand < 0 || !instance.scenario.controllers[static_cast<std::size_t>(hand)]) continue;
        const XrPath user_path = instance.paths.fromString(path.user_path);
        const auto& subactions = action.subaction_paths;
        if (!subactions.empty() &&
            std::find(subactions.begin(), subactions.end(), user_path) == subactions.end()) {
            continue;
        }
        auto components = componentsFor(profile, path, action.action_type);
        if (!components.empty()) bindings.push_back({suggested.path, user_path, hand, std::move(components)});
    }
    return bindings;
}

void attach(Session& session, const std::vector<ActionSet*>& sets) {
    Instance& instance = session.instance;
    const Profile& profile = *findProfile(instance.scenario.profile);
    const bool suggested = instance.suggestions.contains(profile.path);
    InputState input;
    for (ActionSet* set : sets) {
        set->attached = true;
        input.set_priorities[set->handle] = set->priority;
        for (const Object* child : set->children) {
            const auto& action = static_cast<const Action&>(*child);
            AttachedAction& attached = input.actions[action.handle];
            attached.set = set->handle;
            attached.type = action.action_type;
            attached.values[XR_NULL_PATH] = {};
            for (const XrPath path : action.subaction_paths)
                attached.values[path] = {};
            if (suggested) attached.bindings = bindingsOf(instance, action, profile);
        }
    }
    for (const ProfileDevice& device : profile.devices) {
        const int hand = handOf(device.user_path);
        if (!suggested || hand < 0 || !instance.scenario.controllers[static_cast<std::size_t>(hand)])
            continue;
        input.next_profile[static_cast<std::size_t>(hand)] = instance.paths.fromString(profile.path);
    }
    input.attached = true;
    session.input = std::move(input);
}

const AttachedAction& attachedAction(const Session& session, const Action& action) {
    const auto attached = session.input.actions.find(action.handle);
    require(attached != session.input.actions.end(), XR_ERROR_ACTIONSET_NOT_ATTACHED,
            "the action's set is not attached to the session");
    return attached->second;
}

// What all xrGetActionState* share. `state` has been checked.
const ActionValue& actionValue(Call& call, XrSession handle, const XrActionStateGetInfo* info,
                               XrActionType type) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_ACTION_STATE_GET_INFO);
    const Action& action = call.live<Action>(info->action);
    requireSubaction(session.instance, action, info->subactionPath);
    require(action.action_type == type, XR_ERROR_ACTION_TYPE_MISMATCH, "the action is of another type");
    return attachedAction(session, action).values.at(info->subactionPath);
}

template <class State>
void fillState(const ActionValue& value, State& state) {
    state.changedSinceLastSync = value.changed;
    state.lastChangeTime = value.last_change_ns;
    state.isActive = value.active;
}

void changeProfile(Session& session) {
    if (session.input.profile == session.input.next_profile) return;
    session.input.profile = session.input.next_profile;
    const auto handle = handleOf<XrSession>(session);
    session.instance.events.push(
        XrEventDataInteractionProfileChanged{XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr, handle},
        handle);
}

// Whether the active set names a subaction path that an action of the set was created with.
bool hasSubaction(const InputState& input, std::uint64_t set, XrPath path) {
    return std::any_of(input.actions.begin(), input.actions.end(), [&](const auto& entry) {
        return entry.second.set == set && entry.second.values.contains(path);
    });
}

bool requireHapticAction(Call& call, XrSession handle, const XrHapticActionInfo* info) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_HAPTIC_ACTION_INFO);
    const Action& action = call.live<Action>(info->action);
    requireSubaction(session.instance, action, info->subactionPath);
    require(action.action_type == XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
            "not a vibration action");
    attachedAction(session, action);
    return session.progress.state == XR_SESSION_STATE_FOCUSED;
}

}  // namespace

XrResult createActionSet(Call& call, XrInstance handle, const XrActionSetCreateInfo* info, XrActionSet* out) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_ACTION_SET_CREATE_INFO);
    require(out != nullptr, XR_ERROR_VALIDATION_FAILURE, "actionSet is null");
    checkNames(info->actionSetName, info->localizedActionSetName);
    checkUnique<ActionSet>(instance, info->actionSetName, info->localizedActionSetName);
    auto set = std::make_unique<ActionSet>(instance);
    set->name = info->actionSetName;
    set->localized_name = info->localizedActionSetName;
    set->priority = info->priority;
    *out = handleOf<XrActionSet>(call.create(std::move(set), &instance));
    return XR_SUCCESS;
}

XrResult destroyActionSet(Call& call, XrActionSet handle) {
    runtime().handles.destroy(call.evenLost<ActionSet>(handle));
    return XR_SUCCESS;
}

XrResult createAction(Call& call, XrActionSet handle, const XrActionCreateInfo* info, XrAction* out) {
    ActionSet& set = call.live<ActionSet>(handle);
    requireStruct(info, XR_TYPE_ACTION_CREATE_INFO);
    require(out != nullptr, XR_ERROR_VALIDATION_FAILURE, "action is null");
    require(!set.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the set is attached and cannot change");
    checkNames(info->actionName, info->localizedActionName);
    require(
        (info->actionType >= XR_ACTION_TYPE_BOOLEAN_INPUT && info->actionType <= XR_ACTION_TYPE_POSE_INPUT) ||
            info->actionType == XR_ACTION_TYPE_VIBRATION_OUTPUT,
        XR_ERROR_VALIDATION_FAILURE, "actionType is no known value");
    require(info->countSubactionPaths == 0 || info->subactionPaths != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "subactionPaths is null");
    std::set<XrPath> seen;
    for (std::uint32_t i = 0; i < info->countSubactionPaths; ++i) {
        requireUserPath(set.instance, info->subactionPaths[i]);
        require(seen.insert(info->subactionPaths[i]).second, XR_ERROR_PATH_UNSUPPORTED,
                "a subaction path is there twice");
    }
    checkUnique<Action>(set, info->actionName, info->localizedActionName);
    auto action = std::make_unique<Action>(set);
    action->name = info->actionName;
    action->localized_name = info->localizedActionName;
    action->action_type = info->actionType;
    action->subaction_paths.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
    *out = handleOf<XrAction>(call.create(std::move(action), &set));
    return XR_SUCCESS;
}

XrResult destroyAction(Call& call, XrAction handle) {
    runtime().handles.destroy(call.evenLost<Action>(handle));
    return XR_SUCCESS;
}

XrResult suggestInteractionProfileBindings(Call& call, XrInstance handle,
                                           const XrInteractionProfileSuggestedBinding* info) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    require(info->countSuggestedBindings > 0 && info->suggestedBindings != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "there are no suggested bindings");
    const std::string& profile_path = pathString(instance, info->interactionProfile);
    const Profile* profile = findProfile(profile_path);
    require(profile != nullptr, XR_ERROR_PATH_UNSUPPORTED, "not an interaction profile of OpenXR 1.0");
    std::vector<SuggestedBinding> suggestions;
    for (std::uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
        const XrActionSuggestedBinding& suggested = info->suggestedBindings[i];
        const Action& action = call.live<Action>(suggested.action);
        require(!action.set.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
                "the action's set is attached already");
        const std::string& string = pathString(instance, suggested.binding);
        BindingPath path;
        require(splitBindingPath(string, path) && hasComponent(*profile, path), XR_ERROR_PATH_UNSUPPORTED,
                "the profile has no such binding path");
        suggestions.push_back({action.handle, suggested.binding});
    }
    instance.suggestions[profile_path] = std::move(suggestions);
    return XR_SUCCESS;
}

XrResult attachSessionActionSets(Call& call, XrSession handle, const XrSessionActionSetsAttachInfo* info) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    require(info->countActionSets > 0 && info->actionSets != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "there are no action sets");
    std::vector<ActionSet*> sets;
    for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
        sets.push_back(&call.live<ActionSet>(info->actionSets[i]));
        require(&sets.back()->instance == &session.instance, XR_ERROR_VALIDATION_FAILURE,
                "an action set is of another instance");
    }
    require(!session.input.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "action sets are attached once");
    attach(session, sets);
    return XR_SUCCESS;
}

XrResult getCurrentInteractionProfile(Call& call, XrSession handle, XrPath path,
                                      XrInteractionProfileState* state) {
    const Session& session = call.live<Session>(handle);
    requireStruct(state, XR_TYPE_INTERACTION_PROFILE_STATE);
    requireUserPath(session.instance, path);
    require(session.input.attached, XR_ERROR_ACTIONSET_NOT_ATTACHED, "no action sets are attached");
    const int hand = handOf(pathString(session.instance, path));
    state->interactionProfile =
        hand < 0 ? XR_NULL_PATH : session.input.profile[static_cast<std::size_t>(hand)];
    return XR_SUCCESS;
}

XrResult getActionStateBoolean(Call& call, XrSession session, const XrActionStateGetInfo* info,
                               XrActionStateBoolean* state) {
    call.live<Session>(session);
    requireStruct(state, XR_TYPE_ACTION_STATE_BOOLEAN);
    const ActionValue& value = actionValue(call, session, info, XR_ACTION_TYPE_BOOLEAN_INPUT);
    state->currentState = value.x != 0;
    fillState(value, *state);
    return XR_SUCCESS;
}

XrResult getActionStateFloat(Call& call, XrSession session, const XrActionStateGetInfo* info,
                             XrActionStateFloat* state) {
    call.live<Session>(session);
    requireStruct(state, XR_TYPE_ACTION_STATE_FLOAT);
    const ActionValue& value = actionValue(call, session, info, XR_ACTION_TYPE_FLOAT_INPUT);
    state->currentState = static_cast<float>(value.x);
    fillState(value, *state);
    return XR_SUCCESS;
}

XrResult getActionStateVector2f(Call& call, XrSession session, const XrActionStateGetInfo* info,
                                XrActionStateVector2f* state) {
    call.live<Session>(session);
    requireStruct(state, XR_TYPE_ACTION_STATE_VECTOR2F);
    const ActionValue& value = actionValue(call, session, info, XR_ACTION_TYPE_VECTOR2F_INPUT);
    state->currentState = {static_cast<float>(value.x), static_cast<float>(value.y)};
    fillState(value, *state);
    return XR_SUCCESS;
}

XrResult getActionStatePose(Call& call, XrSession session, const XrActionStateGetInfo* info,
                            XrActionStatePose* state) {
    call.live<Session>(session);
    requireStruct(state, XR_TYPE_ACTION_STATE_POSE);
    state->isActive = actionValue(call, session, info, XR_ACTION_TYPE_POSE_INPUT).active;
    return XR_SUCCESS;
}

XrResult syncActions(Call& call, XrSession handle, const XrActionsSyncInfo* info) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_ACTIONS_SYNC_INFO);
    direct(session.instance, session.instance.clock.now(call.now_ns));
    call.live<Session>(handle);  // it may have been lost just now
    require(info->countActiveActionSets == 0 || info->activeActionSets != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "activeActionSets is null");
    std::vector<ActiveSet> active;
    for (std::uint32_t i = 0; i < info->countActiveActionSets; ++i) {
        const XrActiveActionSet& each = info->activeActionSets[i];
        const ActionSet& set = call.live<ActionSet>(each.actionSet);
        require(session.input.set_priorities.contains(set.handle), XR_ERROR_ACTIONSET_NOT_ATTACHED,
                "an action set is not attached to the session");
        if (each.subactionPath != XR_NULL_PATH) {
            pathString(session.instance, each.subactionPath);
            require(hasSubaction(session.input, set.handle, each.subactionPath), XR_ERROR_PATH_UNSUPPORTED,
                    "no action of the set was created with the subaction path");
        }
        active.push_back({set.handle, each.subactionPath});
    }
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) {
        releaseInput(session.input);
        return XR_SESSION_NOT_FOCUSED;
    }
    changeProfile(session);
    const Clock& clock = session.instance.clock;
    const std::int64_t now_ns = clock.now(call.now_ns);
    syncInput(session.input, session.instance.scenario, active, clock.scenarioSeconds(now_ns), now_ns);
    return XR_SUCCESS;
}

XrResult enumerateBoundSourcesForAction(Call& call, XrSession handle,
                                        const XrBoundSourcesForActionEnumerateInfo* info,
                                        std::uint32_t capacity, std::uint32_t* count, XrPath* sources) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO);
    const AttachedAction& action = attachedAction(session, call.live<Action>(info->action));
    std::vector<XrPath> bound;
    for (const Binding& binding : action.bindings) {
        const bool current = session.input.profile[static_cast<std::size_t>(binding.hand)] != XR_NULL_PATH;
        if (current && std::find(bound.begin(), bound.end(), binding.source) == bound.end()) {
            bound.push_back(binding.source);
        }
    }
    return twoCall(capacity, count, sources, bound);
}

XrResult getInputSourceLocalizedName(Call& call, XrSession handle,
                                     const XrInputSourceLocalizedNameGetInfo* info, std::uint32_t capacity,
                                     std::uint32_t* count, char* buffer) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO);
    require(info->whichComponents != 0 && (info->whichComponents & ~kAllNameComponents) == 0,
            XR_ERROR_VALIDATION_FAILURE, "whichComponents is empty or has unknown bits");
    const std::string& source = pathString(session.instance, info->sourcePath);
    require(session.input.attached, XR_ERROR_ACTIONSET_NOT_ATTACHED, "no action sets are attached");
    const Profile& profile = *findProfile(session.instance.scenario.profile);
    BindingPath path;
    require(splitBindingPath(source, path) && hasComponent(profile, path), XR_ERROR_PATH_UNSUPPORTED,
            "the current interaction profile has no such source");
    return twoCallString(capacity, count, buffer, localizedName(profile, path, info->whichComponents));
}

XrResult applyHapticFeedback(Call& call, XrSession handle, const XrHapticActionInfo* info,
                             const XrHapticBaseHeader* feedback) {
    const bool focused = requireHapticAction(call, handle, info);
    requireStruct(feedback, XR_TYPE_HAPTIC_VIBRATION);
    if (!focused) return XR_SESSION_NOT_FOCUSED;
    ++call.live<Session>(handle).instance.statistics.haptic_pulses;
    return XR_SUCCESS;
}

XrResult stopHapticFeedback(Call& call, XrSession handle, const XrHapticActionInfo* info) {
    return requireHapticAction(call, handle, info) ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED;
}

}  // namespace xrmock
