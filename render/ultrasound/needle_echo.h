// How a needle shows in one scan line.
#pragma once

#include <span>

#include "render/ultrasound/transducer.h"

namespace stylet::render {

using patient::Pose;
using patient::Vec3;

struct NeedleShape {
    double radius_m = 0.00074, length_m = 0.200;  // 17 G
};

// Bright where the beam meets the shaft at nearly a right angle, and only within the beam's thickness.
struct NeedleEcho {
    double depth_m = 0.0;    // along the line; 0: neither seen nor in the shadow
    double amplitude = 0.0;  // of a perfect mirror's; 0: not seen
    double shadow = 0.0;     // share of the sound that does not pass it
};
NeedleEcho needleEcho(const Transducer&, const ScanLine&, double pitch_m, const Pose& probe_from_needle,
                      const NeedleShape&, double reflectivity);

// The shadows of a picture's lines, from side to side, as an aperture casts them: a needle that ends keeps
// the sound of some elements only from the lines beside it. A line without an echo gets the depth at which
// its neighbour's shadow begins.
void spreadShadows(const Transducer&, std::span<NeedleEcho>);

inline constexpr double kNeedleLobe_rad = 0.523599;  // full width of the glint at half of its amplitude

}  // namespace stylet::render
