// Input values of the devices at a time. They come from the scenario, or from a test that has taken control
// through XR_EXT_conformance_automation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "scenario/automation.h"
#include "scenario/frame_loop.h"
#include "scenario/scenario.h"

namespace xrmock {

struct Sources {
    const Scenario& scenario;
    const Automation& automation;
    const Clock& clock;
};

// Interaction profile of the connected device; empty: none.
const std::string& profileAt(const Sources& sources, User user, std::int64_t time_ns);

struct SourceValue {
    double value = 0;
    std::int64_t changed_ns = 0;  // XrTime of the last change; 0: never changed
};
// Value of a component such as "input/trigger/value". Buttons return 0 or 1; other values are clamped to
// their range.
SourceValue inputAt(const Sources& sources, User user, std::string_view component, std::int64_t time_ns);

// Pose of a hand's "input/grip/pose" or other pose component, whether or not a device is connected.
Pose stageFromSource(const Sources& sources, User user, std::string_view component, std::int64_t time_ns);

constexpr double kPressed = 0.5;   // an analogue value is pressed from here on
constexpr double kReleased = 0.4;  // and released below this

bool isButton(std::string_view component);

}  // namespace xrmock
