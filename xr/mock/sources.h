// What the devices give at a time: the scenario's, unless a test has taken control.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "automation.h"
#include "frame_loop.h"
#include "scenario.h"

namespace xrmock {

struct Sources {
    const Scenario& scenario;
    const Automation& automation;
    const Clock& clock;
};

// The interaction profile of the device that is there; empty: none.
const std::string& profileAt(const Sources& sources, User user, std::int64_t time_ns);

struct SourceValue {
    double value = 0;
    std::int64_t changed_ns = 0;  // XrTime of the change to this value, 0: none yet
};
// Of a component like "input/trigger/value". Buttons give 0 or 1, other values are clamped to their range.
SourceValue inputAt(const Sources& sources, User user, std::string_view component, std::int64_t time_ns);

// Of "input/grip/pose" and other pose components of a hand, whether a device is there or not.
Pose stageFromSource(const Sources& sources, User user, std::string_view component, std::int64_t time_ns);

constexpr double kPressed = 0.5;   // an analogue value counts as a press from here
constexpr double kReleased = 0.4;  // and is let go below

bool isButton(std::string_view component);

}  // namespace xrmock
