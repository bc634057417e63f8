// Action states of a session. Holds its own copy of what was attached: handles may be destroyed afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "openxr_api.h"
#include "profiles.h"
#include "sources.h"

namespace xrmock {

struct SuggestedBinding {
    std::uint64_t action;
    XrPath path;
};

struct Binding {
    const Profile* profile;  // it holds while this is the user's profile
    User user;
    XrPath source;                        // the path as it was suggested
    XrPath user_path;                     // subaction path it belongs to
    std::vector<std::string> components;  // "input/select/click"; two for a vector
};

struct ActionValue {
    bool active = false;
    double x = 0, y = 0;
    bool changed = false;
    std::int64_t last_change_ns = 0;
    // A pose action follows one user for good: the first that was there when it was synchronised.
    std::optional<User> followed;
    std::string component;  // the pose it follows, "input/grip/pose"
};

struct AttachedAction {
    std::uint64_t set = 0;
    std::string name;
    XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
    std::vector<Binding> bindings;  // of every profile with suggestions
    // XR_NULL_PATH stands for all subaction paths together.
    std::map<XrPath, ActionValue> values;
};

struct InputState {
    bool attached = false;
    std::map<std::uint64_t, std::uint32_t> set_priorities;  // by action set handle
    std::map<std::uint64_t, AttachedAction> actions;        // by action handle
    std::set<const Profile*> suggested;                     // the profiles that have bindings
    // The current one of each user, null for none. Changes when actions are synchronised.
    std::array<const Profile*, kUserCount> profiles{};
    std::set<std::pair<User, std::string>, std::less<>> pressed;  // analogue components past the threshold
};

struct ActiveSet {
    std::uint64_t set;
    XrPath subaction_path;  // XR_NULL_PATH for all
};

bool isLive(const InputState& input, const Binding& binding);

// The current profiles from now on. True if one of them is another than before.
bool updateProfiles(InputState& input, const Sources& sources, std::int64_t now_ns);
// Reads the devices. Where two active sets want the same source, the higher priority has it; priorities that
// are not given are those that the sets were created with.
using Priorities = std::map<std::uint64_t, std::uint32_t>;  // by action set handle
void syncInput(InputState& input, const Sources& sources, const std::vector<ActiveSet>& active,
               Priorities priorities, std::int64_t now_ns);
// Makes every action inactive.
void releaseInput(InputState& input);

// Where the pose action was and will be; nothing while it is inactive or its device is gone.
std::optional<Pose> stageFromAction(const InputState& input, const Sources& sources, std::uint64_t action,
                                    XrPath subaction_path, std::int64_t time_ns);

}  // namespace xrmock
