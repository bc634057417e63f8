#include "input.h"

#include <algorithm>
#include <cmath>

namespace xrmock {

namespace {

constexpr double kPressed = 0.5;  // an analogue value counts as a press from here

// The parts of bindings that name one physical control.
using SourceKey = std::pair<int, std::string>;

double readComponent(const Scenario& scenario, int hand, const std::string& component, double t_s) {
    // Bindings are made for connected controllers only.
    const auto& values = scenario.controllers[static_cast<std::size_t>(hand)].value().values;
    const auto keys = values.find(component.substr(std::string("input/").size()));
    return keys == values.end() ? 0.0 : valueAt(keys->second, t_s);
}

bool isSetActive(const std::vector<ActiveSet>& active, std::uint64_t set, XrPath user_path) {
    return std::any_of(active.begin(), active.end(), [&](const ActiveSet& each) {
        return each.set == set && (each.subaction_path == XR_NULL_PATH || each.subaction_path == user_path);
    });
}

std::map<SourceKey, std::uint32_t> highestPriorities(const InputState& input,
                                                     const std::vector<ActiveSet>& active) {
    std::map<SourceKey, std::uint32_t> highest;
    for (const auto& [handle, action] : input.actions) {
        const std::uint32_t priority = input.set_priorities.at(action.set);
        for (const Binding& binding : action.bindings) {
            if (!isSetActive(active, action.set, binding.user_path)) continue;
            for (const std::string& component : binding.components) {
                // Controls are suppressed whole: "trigger/value" takes "trigger/click" with it.
                const std::string control = component.substr(0, component.rfind('/'));
                std::uint32_t& entry = highest[{binding.hand, control}];
                entry = std::max(entry, priority);
            }
        }
    }
    return highest;
}

// Several sources for one action: any press, the largest deflection, the first pose.
void mix(ActionValue& value, const Binding& binding, XrActionType type, const Scenario& scenario,
         double t_s) {
    const auto read = [&](std::size_t i) {
        return readComponent(scenario, binding.hand, binding.components[i], t_s);
    };
    const bool was_active = value.active;
    value.active = true;
    switch (type) {
        case XR_ACTION_TYPE_BOOLEAN_INPUT:
            value.x = std::max(value.x, read(0) >= kPressed ? 1.0 : 0.0);
            break;
        case XR_ACTION_TYPE_FLOAT_INPUT:
            if (const double x = read(0); std::abs(x) > std::abs(value.x)) value.x = x;
            break;
        case XR_ACTION_TYPE_VECTOR2F_INPUT:
            if (const double x = read(0), y = read(1);
                x * x + y * y > value.x * value.x + value.y * value.y) {
                value.x = x;
                value.y = y;
            }
            break;
        case XR_ACTION_TYPE_POSE_INPUT:
            if (!was_active) value.hand = binding.hand;
            break;
        default:
            break;
    }
}

}  // namespace

void syncInput(InputState& input, const Scenario& scenario, const std::vector<ActiveSet>& active,
               double scenario_time_s, std::int64_t now_ns) {
    const auto highest = highestPriorities(input, active);
    for (auto& [handle, action] : input.actions) {
        const std::uint32_t priority = input.set_priorities.at(action.set);
        for (auto& [subaction_path, value] : action.values) {
            ActionValue next;
            for (const Binding& binding : action.bindings) {
                if (subaction_path != XR_NULL_PATH && subaction_path != binding.user_path) continue;
                if (!isSetActive(active, action.set, binding.user_path)) continue;
                const std::string& component = binding.components.front();
                if (highest.at({binding.hand, component.substr(0, component.rfind('/'))}) > priority)
                    continue;
                mix(next, binding, action.type, scenario, scenario_time_s);
            }
            if (next.active) {
                next.changed = value.active && (next.x != value.x || next.y != value.y);
                next.last_change_ns = next.changed || !value.active ? now_ns : value.last_change_ns;
            }
            value = next;
        }
    }
}

void releaseInput(InputState& input) {
    for (auto& [handle, action] : input.actions) {
        for (auto& [subaction_path, value] : action.values)
            value = {};
    }
}

std::optional<int> poseHand(const InputState& input, std::uint64_t action, XrPath subaction_path) {
    const auto attached = input.actions.find(action);
    if (attached == input.actions.end()) return std::nullopt;
    const auto value = attached->second.values.find(subaction_path);
    return value == attached->second.values.end() ? std::nullopt : value->second.hand;
}

}  // namespace xrmock
