// Guide wire, dilator and drain of a tick as curved tubes for pictures.
#pragma once

#include <optional>
#include <vector>

#include "base/curved_tube.h"
#include "haptics/haptics.h"

namespace stylet::trainer {

// Length of drain and wire beyond the skin or the needle's hub.
inline constexpr double kTubeOutside_m = 0.12;

// `needle_m`: length of the needle, from whose hub the wire emerges. The drain's pigtail curls once the drain
// is in place.
std::vector<CurvedTube> accessTubes(const haptics::TickOutput&, const haptics::AccessSettings&,
                                    const patient::MotionModel&, double needle_m);

// Where the tip of the wire, dilator or drain in hand lies in the body, deformed patient; nothing if none
// does.
std::optional<Vec3> tipOnTrack_m(const haptics::TickOutput&, const patient::MotionModel&);

// Removes the points of a curve that lie within `tolerance_m` of the remaining ones (Douglas and Peucker
// 1973).
std::vector<Vec3> simplifyCurve(const std::vector<Vec3>& points_m, double tolerance_m);

}  // namespace stylet::trainer
