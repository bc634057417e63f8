// Poses of the tools that one hand holds in turn.
#pragma once

#include "haptics/loop/toolbox.h"

namespace stylet::trainer {

// Pose of `tool` when it replaces a needle with the given pose. The pose stays the same, except for the
// probe: its guide line coincides with the needle, and its face is at the needle's tip.
Pose toolPoseFromNeedle(const Pose& patient_from_needle, haptics::Tool, const haptics::GuideSettings&);

// Needle pose with the tip at `tip_m`. The shaft points INTO the body along `axis` (unit vector).
Pose needlePose(const Vec3& tip_m, const Vec3& axis);

// The smallest rotation that turns the unit vector `from` to `to`.
Quat rotationBetween(const Vec3& from, const Vec3& to);

}  // namespace stylet::trainer
