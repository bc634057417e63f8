// Hand joints (XR_EXT_hand_tracking). They are recorded, or computed for a hand of average size with curling
// fingers.
#pragma once

#include <cstdint>
#include <optional>

#include "scenario/devices.h"
#include "scenario/sources.h"

namespace xrmock {

// Joint frames as in the extension: -z along the bone towards the tip, +y out of the back of the hand. The
// palm joint is at the middle of the middle finger's metacarpal bone.
Joints builtInHand(bool is_left, const Pose& stage_from_palm, const Curls& curls);

// Transform from the palm joint to the grip pose.
Pose gripFromPalm(bool is_left);

// Returns nullopt while the hand is not visible.
std::optional<Joints> stageFromJoints(const Sources& sources, bool is_left, std::int64_t time_ns);

}  // namespace xrmock
