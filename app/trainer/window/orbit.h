// The free camera. It turns about a point of the room.
#pragma once

#include "render/scene/scene.h"

namespace stylet::trainer {

struct Orbit {
    Vec3 middle_m{0.0};        // stage frame
    double azimuth_rad = 0.0;  // 0: seen from +z, the operator's side; > 0: from the operator's right
    double elevation_rad = 0.6;
    double distance_m = 1.0;
    friend bool operator==(const Orbit&, const Orbit&) = default;
};

inline constexpr double kMinElevation_rad = -0.3, kMaxElevation_rad = 1.5;
inline constexpr double kMinDistance_m = 0.15, kMaxDistance_m = 3.5;
inline constexpr double kOrbitHalfHeight_rad = 0.42;  // half of the vertical field of view

// Applies a drag, in fractions of the picture's height. The scene follows the pointer.
void turn(Orbit&, double right, double up);
void pan(Orbit&, double right, double up);
// `steps`: steps of the wheel; > 0: closer.
void zoom(Orbit&, double steps);
// `aspect`: width over height of the picture.
render::View orbitView(const Orbit&, double aspect);

}  // namespace stylet::trainer
