#include <algorithm>
#include <memory>
#include <set>

#include "api/api.h"
#include "scenario/profiles.h"
#include "world/localized_names.h"
#include "world/objects.h"
#include "world/two_call.h"
#include "world/verify.h"

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

// Names must be unique among the live children of a parent.
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

void requireSubactionPath(const Instance& instance, XrPath path) {
    const auto user = findUser(pathString(instance, path));
    require(user && *user != User::treadmill, XR_ERROR_PATH_UNSUPPORTED, "not a subaction path");
}

// All suggested bindings of an action, for every profile.
std::vector<Binding> collectBindings(Instance& instance, const Action& action) {
    std::vector<Binding> bindings;
    for (const auto& [profile_path, suggestions] : instance.suggestions) {
        const Profile& profile = *findProfile(profile_path);
        for (const SuggestedBinding& suggested : suggestions) {
            if (suggested.action != action.handle) continue;
            const BindingPath path = splitBindingPath(*instance.paths.toString(suggested.path)).value();
            const XrPath user_path = instance.paths.fromString(userPath(path.user));
            const auto& subactions = action.subaction_paths;
            if (!subactions.empty() &&
                std::find(subactions.begin(), subactions.end(), user_path) == subactions.end()) {
                continue;
            }
            auto components = componentsFor(profile, path, action.action_type);
            // No component of this path fits the action's type. This is no error; there is just no binding.
            if (components.empty()) continue;
            bindings.push_back({&profile, path.user, suggested.path, user_path, std::move(components)});
        }
    }
    return bindings;
}

void attach(Session& session, const std::vector<ActionSet*>& sets) {
    Instance& instance = session.instance;
    InputState input;
    for (const auto& [profile_path, suggestions] : instance.suggestions)
        input.suggested.insert(findProfile(profile_path));
    for (ActionSet* set : sets) {
        set->attached = true;
        input.set_priorities[set->handle] = set->priority;
        for (const Object* child : set->children) {
            const auto& action = static_cast<const Action&>(*child);
            AttachedAction& attached = input.actions[action.handle];
            attached.set = set->handle;
            attached.name = action.name;
            attached.type = action.action_type;
            attached.values[XR_NULL_PATH] = {};
            for (const XrPath path : action.subaction_paths)
                attached.values[path] = {};
            attached.bindings = collectBindings(instance, action);
        }
    }
    input.attached = true;
    session.input = std::move(input);
}

}  // namespace

XrResult createActionSet(Call& call, XrInstance handle, const XrActionSetCreateInfo* info, XrActionSet* out) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_ACTION_SET_CREATE_INFO);
    requireValid(out != nullptr, "actionSet is null");
    checkNames(info->actionSetName, info->localizedActionSetName);
    checkUnique<ActionSet>(instance, info->actionSetName, info->localizedActionSetName);
    auto set = std::make_unique<ActionSet>(instance);
    set->name = info->actionSetName;
    set->localized_name = info->localizedActionSetName;
    set->priority = info->priority;
    *out = toHandle<XrActionSet>(call.create(std::move(set), &instance));
    return XR_SUCCESS;
}

XrResult createAction(Call& call, XrActionSet handle, const XrActionCreateInfo* info, XrAction* out) {
    ActionSet& set = call.live<ActionSet>(handle);
    requireStruct(info, XR_TYPE_ACTION_CREATE_INFO);
    requireValid(out != nullptr, "action is null");
    require(!set.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "the set is attached and cannot change");
    checkNames(info->actionName, info->localizedActionName);
    requireValid(
        (info->actionType >= XR_ACTION_TYPE_BOOLEAN_INPUT && info->actionType <= XR_ACTION_TYPE_POSE_INPUT) ||
            info->actionType == XR_ACTION_TYPE_VIBRATION_OUTPUT,
        "actionType is no known value");
    requireValid(info->countSubactionPaths == 0 || info->subactionPaths != nullptr, "subactionPaths is null");
    std::set<XrPath> seen;
    for (std::uint32_t i = 0; i < info->countSubactionPaths; ++i) {
        requireSubactionPath(set.instance, info->subactionPaths[i]);
        require(seen.insert(info->subactionPaths[i]).second, XR_ERROR_PATH_UNSUPPORTED,
                "a subaction path is there twice");
    }
    checkUnique<Action>(set, info->actionName, info->localizedActionName);
    auto action = std::make_unique<Action>(set);
    action->name = info->actionName;
    action->localized_name = info->localizedActionName;
    action->action_type = info->actionType;
    action->subaction_paths.assign(info->subactionPaths, info->subactionPaths + info->countSubactionPaths);
    *out = toHandle<XrAction>(call.create(std::move(action), &set));
    return XR_SUCCESS;
}

XrResult suggestInteractionProfileBindings(Call& call, XrInstance handle,
                                           const XrInteractionProfileSuggestedBinding* info) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
    requireValid(info->countSuggestedBindings > 0 && info->suggestedBindings != nullptr,
                 "there are no suggested bindings");
    const std::string& profile_path = pathString(instance, info->interactionProfile);
    const Profile* profile = findProfile(profile_path, instance.extensions);
    require(profile != nullptr, XR_ERROR_PATH_UNSUPPORTED,
            "not an interaction profile of OpenXR 1.0 or an enabled extension");
    std::vector<SuggestedBinding> suggestions;
    for (std::uint32_t i = 0; i < info->countSuggestedBindings; ++i) {
        const XrActionSuggestedBinding& suggested = info->suggestedBindings[i];
        const Action& action = call.live<Action>(suggested.action);
        require(!action.set.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED,
                "the action's set is attached already");
        requireValid(&action.set.instance == &instance, "an action is of another instance");
        const auto path = splitBindingPath(pathString(instance, suggested.binding));
        require(path && hasComponent(*profile, *path, instance.extensions), XR_ERROR_PATH_UNSUPPORTED,
                "the profile has no such binding path");
        suggestions.push_back({action.handle, suggested.binding});
    }
    instance.suggestions[profile_path] = std::move(suggestions);
    return XR_SUCCESS;
}

XrResult attachSessionActionSets(Call& call, XrSession handle, const XrSessionActionSetsAttachInfo* info) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
    requireValid(info->countActionSets > 0 && info->actionSets != nullptr, "there are no action sets");
    std::vector<ActionSet*> sets;
    for (std::uint32_t i = 0; i < info->countActionSets; ++i) {
        sets.push_back(&call.live<ActionSet>(info->actionSets[i]));
        requireValid(&sets.back()->instance == &session.instance, "an action set is of another instance");
    }
    require(!session.input.attached, XR_ERROR_ACTIONSETS_ALREADY_ATTACHED, "action sets are attached once");
    attach(session, sets);
    return XR_SUCCESS;
}

XrResult getCurrentInteractionProfile(Call& call, XrSession handle, XrPath path,
                                      XrInteractionProfileState* state) {
    const Session& session = call.live<Session>(handle);
    requireStruct(state, XR_TYPE_INTERACTION_PROFILE_STATE);
    const auto user = findUser(pathString(session.instance, path));
    require(user.has_value(), XR_ERROR_PATH_UNSUPPORTED, "not a top level user path");
    require(session.input.attached, XR_ERROR_ACTIONSET_NOT_ATTACHED, "no action sets are attached");
    const Profile* profile = session.input.profiles[static_cast<std::size_t>(*user)];
    state->interactionProfile =
        profile == nullptr ? XR_NULL_PATH : session.instance.paths.fromString(profile->path);
    return XR_SUCCESS;
}

XrResult enumerateBoundSourcesForAction(Call& call, XrSession handle,
                                        const XrBoundSourcesForActionEnumerateInfo* info,
                                        std::uint32_t capacity, std::uint32_t* count, XrPath* sources) {
    const Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO);
    const AttachedAction& action = attachedAction(session.input, call.live<Action>(info->action));
    std::vector<XrPath> bound;
    for (const Binding& binding : action.bindings) {
        if (isBindingActive(session.input, binding) &&
            std::find(bound.begin(), bound.end(), binding.source) == bound.end()) {
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
    requireValid(info->whichComponents != 0 && (info->whichComponents & ~kAllNameComponents) == 0,
                 "whichComponents is empty or has unknown bits");
    const std::string& source = pathString(session.instance, info->sourcePath);
    require(session.input.attached, XR_ERROR_ACTIONSET_NOT_ATTACHED, "no action sets are attached");
    const auto path = splitBindingPath(source);
    require(path.has_value(), XR_ERROR_PATH_UNSUPPORTED, "not the path of a source");
    const Profile* profile = session.input.profiles[static_cast<std::size_t>(path->user)];
    require(profile != nullptr && hasComponent(*profile, *path, session.instance.extensions),
            XR_ERROR_PATH_UNSUPPORTED, "the current interaction profile has no such source");
    return twoCallString(capacity, count, buffer, localizedName(*profile, *path, info->whichComponents));
}

}  // namespace xrmock
