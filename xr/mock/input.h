// Action states of a session. Holds its own copy of what was attached: handles may be destroyed afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "openxr_api.h"
#include "scenario.h"

namespace xrmock {

struct SuggestedBinding {
    std::uint64_t action;
    XrPath path;
};

struct Binding {
    XrPath source;                        // the path as it was suggested
    XrPath user_path;                     // subaction path it belongs to
    int hand;                             // 0 left, 1 right
    std::vector<std::string> components;  // "input/select/click"; two for a vector
};

struct ActionValue {
    bool active = false;
    double x = 0, y = 0;
    bool changed = false;
    std::int64_t last_change_ns = 0;
    std::optional<int> hand;  // whose pose it is
};

struct AttachedAction {
    std::uint64_t set = 0;
    XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
    std::vector<Binding> bindings;
    // XR_NULL_PATH stands for all subaction paths together.
    std::map<XrPath, ActionValue> values;
};

struct InputState {
    bool attached = false;
    std::map<std::uint64_t, std::uint32_t> set_priorities;           // by action set handle
    std::map<std::uint64_t, AttachedAction> actions;                 // by action handle
    std::array<XrPath, 2> profile{XR_NULL_PATH, XR_NULL_PATH};       // of the hands, once synchronised
    std::array<XrPath, 2> next_profile{XR_NULL_PATH, XR_NULL_PATH};  // what the bindings were made for
};

struct ActiveSet {
    std::uint64_t set;
    XrPath subaction_path;  // XR_NULL_PATH for all
};

// Reads the controllers at a time. Where two active sets want the same source, the higher priority has it.
void syncInput(InputState& input, const Scenario& scenario, const std::vector<ActiveSet>& active,
               double scenario_time_s, std::int64_t now_ns);
// Makes every action inactive.
void releaseInput(InputState& input);

// The hand whose pose the action follows since the last synchronisation.
std::optional<int> poseHand(const InputState& input, std::uint64_t action, XrPath subaction_path);

}  // namespace xrmock
