// Action states of a session. Keeps a copy of the attached actions, because their handles may be destroyed
// afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenario/openxr_api.h"
#include "scenario/profiles.h"
#include "scenario/sources.h"

namespace xrmock {

struct SuggestedBinding {
    std::uint64_t action;
    XrPath path;
};

struct Binding {
    const Profile* profile;  // active while this is the user's current profile
    User user;
    XrPath source;                        // path of the suggested binding
    XrPath user_path;                     // subaction path it belongs to
    std::vector<std::string> components;  // "input/select/click"; two for a vector
};

struct ActionValue {
    bool active = false;
    double x = 0, y = 0;
    bool changed = false;
    std::int64_t last_change_ns = 0;
    // A pose action follows one user permanently: the first one with an active binding at a sync.
    std::optional<User> followed;
    std::string component;  // followed pose, "input/grip/pose"
};

struct AttachedAction {
    std::uint64_t set = 0;
    std::string name;
    XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
    std::vector<Binding> bindings;  // for every profile with suggested bindings
    // By subaction path. XR_NULL_PATH combines all subaction paths.
    std::map<XrPath, ActionValue> values;
};

struct InputState {
    bool attached = false;
    std::map<std::uint64_t, std::uint32_t> set_priorities;  // by action set handle
    std::map<std::uint64_t, AttachedAction> actions;        // by action handle
    std::set<const Profile*> suggested;                     // profiles with suggested bindings
    // Current profile of each user, or null. Updated when actions are synchronised.
    std::array<const Profile*, kUserCount> profiles{};
    // Analogue components past the press threshold.
    std::set<std::pair<User, std::string>, std::less<>> pressed;
};

struct ActiveSet {
    std::uint64_t set;
    XrPath subaction_path;  // XR_NULL_PATH: all
};

bool isBindingActive(const InputState& input, const Binding& binding);

// Updates the current profiles. Returns true if any changed.
bool updateProfiles(InputState& input, const Sources& sources, std::int64_t now_ns);
// Reads the devices into the action states. If two active sets bind the same source, only the one with the
// higher priority receives it. Sets missing from `priorities` use the priority they were created with.
using Priorities = std::map<std::uint64_t, std::uint32_t>;  // by action set handle
void syncInput(InputState& input, const Sources& sources, const std::vector<ActiveSet>& active,
               Priorities priorities, std::int64_t now_ns);
// Makes every action inactive.
void releaseInput(InputState& input);

// Pose of the action at any past or future time. Returns nullopt if the action is inactive or its device is
// not connected.
std::optional<Pose> stageFromAction(const InputState& input, const Sources& sources, std::uint64_t action,
                                    XrPath subaction_path, std::int64_t time_ns);

}  // namespace xrmock
