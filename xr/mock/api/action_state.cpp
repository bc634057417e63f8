// Action states, their synchronisation, and haptic output.
#include <algorithm>
#include <cmath>
#include <vector>

#include "api/api.h"
#include "scenario/openxr_later.h"
#include "world/director.h"
#include "world/objects.h"
#include "world/verify.h"

namespace xrmock {

namespace {

// Common part of the xrGetActionState* functions: checks the arguments and returns the action's value.
template <class State>
ActionValue readState(Call& call, XrSession handle, const XrActionStateGetInfo* info, const State* state,
                      XrStructureType state_type, XrActionType action_type) {
    const Session& session = call.live<Session>(handle);
    requireStruct(state, state_type);
    requireStruct(info, XR_TYPE_ACTION_STATE_GET_INFO);
    const Action& action = call.live<Action>(info->action);
    requireSubaction(session.instance, action, info->subactionPath);
    require(action.action_type == action_type, XR_ERROR_ACTION_TYPE_MISMATCH,
            "the action is of another type");
    const ActionValue& value = attachedAction(session.input, action).values.at(info->subactionPath);
    return session.progress.running ? value : ActionValue{};
}

template <class State>
XrResult writeState(const ActionValue& value, State& state) {
    state.changedSinceLastSync = value.changed;
    state.lastChangeTime = value.last_change_ns;
    state.isActive = value.active;
    return XR_SUCCESS;
}

// Returns whether any action of the set was created with the subaction path.
bool hasSubaction(const InputState& input, std::uint64_t set, XrPath path) {
    return std::any_of(input.actions.begin(), input.actions.end(), [&](const auto& entry) {
        return entry.second.set == set && entry.second.values.contains(path);
    });
}

// XR_EXT_active_action_set_priority.
Priorities readPriorities(Call& call, const Session& session, const XrActionsSyncInfo& info) {
    Priorities priorities;
    const auto* given =
        findInChain<XrActiveActionSetPrioritiesEXT>(info.next, XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT);
    if (given == nullptr ||
        !session.instance.extensions.contains(XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME)) {
        return priorities;
    }
    requireValid(given->actionSetPriorityCount == 0 || given->actionSetPriorities != nullptr,
                 "actionSetPriorities is null");
    for (std::uint32_t i = 0; i < given->actionSetPriorityCount; ++i) {
        const XrActiveActionSetPriorityEXT& each = given->actionSetPriorities[i];
        const std::uint64_t set = call.live<ActionSet>(each.actionSet).handle;
        requireValid(priorities.emplace(set, each.priorityOverride).second,
                     "an action set has two priorities");
    }
    return priorities;
}

const AttachedAction& hapticAction(Call& call, const Session& session, const XrHapticActionInfo* info) {
    requireStruct(info, XR_TYPE_HAPTIC_ACTION_INFO);
    const Action& action = call.live<Action>(info->action);
    requireSubaction(session.instance, action, info->subactionPath);
    require(action.action_type == XR_ACTION_TYPE_VIBRATION_OUTPUT, XR_ERROR_ACTION_TYPE_MISMATCH,
            "not a vibration action");
    return attachedAction(session.input, action);
}

// Calls visit(user, component) for each output that the action drives on the subaction path.
template <class Visit>
void forEachOutput(const Session& session, const AttachedAction& action, XrPath subaction_path, Visit visit) {
    for (const Binding& binding : action.bindings) {
        const bool meant = subaction_path == XR_NULL_PATH || subaction_path == binding.user_path;
        if (meant && isBindingActive(session.input, binding)) visit(binding.user, binding.components.front());
    }
}

}  // namespace

XrResult getActionStateBoolean(Call& call, XrSession session, const XrActionStateGetInfo* info,
                               XrActionStateBoolean* state) {
    const ActionValue value =
        readState(call, session, info, state, XR_TYPE_ACTION_STATE_BOOLEAN, XR_ACTION_TYPE_BOOLEAN_INPUT);
    state->currentState = value.x != 0;
    return writeState(value, *state);
}

XrResult getActionStateFloat(Call& call, XrSession session, const XrActionStateGetInfo* info,
                             XrActionStateFloat* state) {
    const ActionValue value =
        readState(call, session, info, state, XR_TYPE_ACTION_STATE_FLOAT, XR_ACTION_TYPE_FLOAT_INPUT);
    state->currentState = static_cast<float>(value.x);
    return writeState(value, *state);
}

XrResult getActionStateVector2f(Call& call, XrSession session, const XrActionStateGetInfo* info,
                                XrActionStateVector2f* state) {
    const ActionValue value =
        readState(call, session, info, state, XR_TYPE_ACTION_STATE_VECTOR2F, XR_ACTION_TYPE_VECTOR2F_INPUT);
    state->currentState = {static_cast<float>(value.x), static_cast<float>(value.y)};
    return writeState(value, *state);
}

XrResult getActionStatePose(Call& call, XrSession session, const XrActionStateGetInfo* info,
                            XrActionStatePose* state) {
    state->isActive =
        readState(call, session, info, state, XR_TYPE_ACTION_STATE_POSE, XR_ACTION_TYPE_POSE_INPUT).active;
    return XR_SUCCESS;
}

XrResult syncActions(Call& call, XrSession handle, const XrActionsSyncInfo* info) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_ACTIONS_SYNC_INFO);
    const std::int64_t now_ns = session.instance.clock.now(call.now_ns);
    applyDueEvents(session.instance, now_ns);
    call.live<Session>(handle);  // throws if an event has caused its loss
    requireValid(info->countActiveActionSets == 0 || info->activeActionSets != nullptr,
                 "activeActionSets is null");
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
    const Priorities priorities = readPriorities(call, session, *info);
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) {
        releaseInput(session.input);
        stopAllPulses(session.haptics, now_ns);
        return XR_SESSION_NOT_FOCUSED;
    }
    const Sources sources = makeSources(session);
    if (updateProfiles(session.input, sources, now_ns)) {
        session.instance.events.push(XrEventDataInteractionProfileChanged{
            XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED, nullptr, handle});
    }
    syncInput(session.input, sources, active, priorities, now_ns);
    return XR_SUCCESS;
}

XrResult applyHapticFeedback(Call& call, XrSession handle, const XrHapticActionInfo* info,
                             const XrHapticBaseHeader* feedback) {
    Session& session = call.live<Session>(handle);
    const AttachedAction& action = hapticAction(call, session, info);
    requireStruct(feedback, XR_TYPE_HAPTIC_VIBRATION);
    const auto& vibration = *reinterpret_cast<const XrHapticVibration*>(feedback);
    requireValid(std::isfinite(vibration.amplitude) && std::isfinite(vibration.frequency),
                 "amplitude or frequency is not a number");
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
    ++session.instance.statistics.haptic_pulses;
    HapticPulse pulse;
    pulse.action = handleValue(info->action);
    pulse.action_name = action.name;
    pulse.start_ns = session.instance.clock.now(call.now_ns);
    pulse.end_ns = pulse.start_ns + std::max<std::int64_t>(vibration.duration, kMinPulseNs);
    pulse.frequency_hz = std::max(double{vibration.frequency}, 0.0);
    pulse.amplitude = std::clamp(double{vibration.amplitude}, 0.0, 1.0);
    forEachOutput(session, action, info->subactionPath, [&](User user, const std::string& output) {
        pulse.user = user;
        pulse.output = output;
        startPulse(session.haptics, pulse);
    });
    return XR_SUCCESS;
}

XrResult stopHapticFeedback(Call& call, XrSession handle, const XrHapticActionInfo* info) {
    Session& session = call.live<Session>(handle);
    const AttachedAction& action = hapticAction(call, session, info);
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) return XR_SESSION_NOT_FOCUSED;
    const std::int64_t now_ns = session.instance.clock.now(call.now_ns);
    forEachOutput(session, action, info->subactionPath, [&](User user, const std::string& output) {
        stopPulses(session.haptics, handleValue(info->action), user, output, now_ns);
    });
    return XR_SUCCESS;
}

}  // namespace xrmock
