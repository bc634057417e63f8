// Echo and shadow of a needle in one scan line.
#pragma once

#include <span>

#include "render/scene/scene.h"
#include "render/ultrasound/transducer.h"

namespace stylet::render {

// The echo is bright where the beam meets the shaft at nearly a right angle, and only within the beam's
// thickness.
struct NeedleEcho {
    double depth_m = 0.0;    // along the line; 0: neither echo nor shadow
    double amplitude = 0.0;  // relative to a perfect mirror's echo; 0: no echo
    double shadow = 0.0;     // share of the sound that the needle blocks
};
NeedleEcho needleEcho(const Transducer&, const ScanLine&, double pitch_m, const Pose& probe_from_needle,
                      const NeedleShape&, double reflectivity);

// Spreads each line's shadow over its neighbours. A whole aperture forms each line, so beside the needle's
// end the needle shades only some of its elements. A line without an echo gets the depth at which its
// neighbour's shadow begins.
void spreadShadows(const Transducer&, std::span<NeedleEcho>);

inline constexpr double kNeedleLobe_rad = 0.523599;  // full width of the glint at half of its amplitude

}  // namespace stylet::render
