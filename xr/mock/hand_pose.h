// The joints of a hand (XR_EXT_hand_tracking): recorded ones, or a built-in hand of average size whose
// fingers curl.
#pragma once

#include <cstdint>
#include <optional>

#include "devices.h"
#include "sources.h"

namespace xrmock {

// Joint frames as the extension has them: -z along the bone to the tip, +y out of the back of the hand. The
// palm is the middle of the middle finger's metacarpal bone.
Joints builtInHand(bool is_left, const Pose& stage_from_palm, const Curls& curls);

// The palm of the hand whose grip pose this is.
Pose gripFromPalm(bool is_left);

// Nothing while the hand is not seen.
std::optional<Joints> stageFromJoints(const Sources& sources, bool is_left, std::int64_t time_ns);

}  // namespace xrmock
