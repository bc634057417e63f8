#include "world/input.h"

#include <algorithm>
#include <cmath>

namespace xrmock {

namespace {

// A physical control, such as "input/trigger", with all its components.
using PhysicalControl = std::pair<User, std::string>;

PhysicalControl physicalControl(const Binding& binding, const std::string& component) {
    return {binding.user, component.substr(0, component.rfind('/'))};
}

bool isSetActive(const std::vector<ActiveSet>& active, std::uint64_t set, XrPath user_path) {
    return std::any_of(active.begin(), active.end(), [&](const ActiveSet& each) {
        return each.set == set && (each.subaction_path == XR_NULL_PATH || each.subaction_path == user_path);
    });
}

std::map<PhysicalControl, std::uint32_t> highestPriorities(const InputState& input,
                                                           const std::vector<ActiveSet>& active,
                                                           const Priorities& priorities) {
    std::map<PhysicalControl, std::uint32_t> highest;
    for (const auto& [handle, action] : input.actions) {
        const std::uint32_t priority = priorities.at(action.set);
        for (const Binding& binding : action.bindings) {
            if (!isBindingActive(input, binding) || !isSetActive(active, action.set, binding.user_path))
                continue;
            for (const std::string& component : binding.components) {
                std::uint32_t& entry = highest[physicalControl(binding, component)];
                entry = std::max(entry, priority);
            }
        }
    }
    return highest;
}

// Returns whether the component counts as pressed, with hysteresis.
bool isPressed(InputState& input, User user, const std::string& component, double value) {
    const auto key = std::make_pair(user, component);
    const bool pressed = value >= (input.pressed.contains(key) ? kReleased : kPressed);
    if (pressed)
        input.pressed.insert(key);
    else
        input.pressed.erase(key);
    return pressed;
}

// Combines several sources of one action: any press, the largest deflection, the longest vector.
// `last_change_ns` becomes that of the latest change.
void combineSource(ActionValue& value, InputState& input, const Binding& binding, XrActionType type,
                   const Sources& sources, std::int64_t now_ns) {
    value.active = true;
    const auto read = [&](std::size_t i) {
        const SourceValue source = inputAt(sources, binding.user, binding.components[i], now_ns);
        value.last_change_ns = std::max(value.last_change_ns, std::min(source.changed_ns, now_ns));
        return source.value;
    };
    if (type == XR_ACTION_TYPE_BOOLEAN_INPUT) {
        if (isPressed(input, binding.user, binding.components[0], read(0))) value.x = 1;
    } else if (type == XR_ACTION_TYPE_FLOAT_INPUT) {
        if (const double x = read(0); std::abs(x) > std::abs(value.x)) value.x = x;
    } else if (type == XR_ACTION_TYPE_VECTOR2F_INPUT) {
        if (const double x = read(0), y = read(1); x * x + y * y > value.x * value.x + value.y * value.y) {
            value.x = x;
            value.y = y;
        }
    }
}

// Sets `changed` and `last_change_ns` of the new value. On entry, `last_change_ns` is the time of the latest
// change of its sources.
void compare(const ActionValue& before, ActionValue& now_value, std::int64_t now_ns) {
    if (!before.active) {
        if (now_value.last_change_ns == 0) now_value.last_change_ns = now_ns;
        return;
    }
    now_value.changed = now_value.x != before.x || now_value.y != before.y;
    if (!now_value.changed)
        now_value.last_change_ns = before.last_change_ns;
    else if (now_value.last_change_ns <= before.last_change_ns)
        now_value.last_change_ns = now_ns;  // other sources contribute now; none has changed
}

}  // namespace

bool isBindingActive(const InputState& input, const Binding& binding) {
    return input.profiles[static_cast<std::size_t>(binding.user)] == binding.profile;
}

bool updateProfiles(InputState& input, const Sources& sources, std::int64_t now_ns) {
    bool changed = false;
    for (std::size_t i = 0; i < kUserCount; ++i) {
        const Profile* profile = findProfile(profileAt(sources, static_cast<User>(i), now_ns));
        if (!input.suggested.contains(profile)) profile = nullptr;
        changed = changed || profile != input.profiles[i];
        input.profiles[i] = profile;
    }
    return changed;
}

void syncInput(InputState& input, const Sources& sources, const std::vector<ActiveSet>& active,
               Priorities priorities, std::int64_t now_ns) {
    priorities.insert(input.set_priorities.begin(), input.set_priorities.end());
    const auto highest = highestPriorities(input, active, priorities);
    for (auto& [handle, action] : input.actions) {
        const std::uint32_t priority = priorities.at(action.set);
        const auto contributes = [&](const Binding& binding, XrPath subaction_path) {
            return isBindingActive(input, binding) &&
                   (subaction_path == XR_NULL_PATH || subaction_path == binding.user_path) &&
                   isSetActive(active, action.set, binding.user_path) &&
                   highest.at(physicalControl(binding, binding.components.front())) <= priority;
        };
        for (auto& [subaction_path, value] : action.values) {
            ActionValue next;
            next.followed = value.followed;
            for (const Binding& binding : action.bindings) {
                if (!contributes(binding, subaction_path)) continue;
                if (action.type != XR_ACTION_TYPE_POSE_INPUT) {
                    combineSource(next, input, binding, action.type, sources, now_ns);
                } else if (!next.active && next.followed.value_or(binding.user) == binding.user) {
                    next.active = true;
                    next.followed = binding.user;
                    next.component = binding.components.front();
                }
            }
            if (next.active) compare(value, next, now_ns);
            value = std::move(next);
        }
    }
}

void releaseInput(InputState& input) {
    for (auto& [handle, action] : input.actions) {
        for (auto& [subaction_path, value] : action.values) {
            const auto followed = value.followed;
            value = {};
            value.followed = followed;
        }
    }
}

std::optional<Pose> stageFromAction(const InputState& input, const Sources& sources, std::uint64_t action,
                                    XrPath subaction_path, std::int64_t time_ns) {
    const auto attached = input.actions.find(action);
    if (attached == input.actions.end()) return std::nullopt;
    const auto value = attached->second.values.find(subaction_path);
    if (value == attached->second.values.end() || !value->second.active) return std::nullopt;
    const User user = value->second.followed.value();
    if (profileAt(sources, user, time_ns).empty()) return std::nullopt;
    return stageFromSource(sources, user, value->second.component, time_ns);
}

}  // namespace xrmock
