#include "app/trainer/window/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/trainer/attempt/staging.h"

namespace stylet::trainer {
namespace {

constexpr double kZoomStep = 1.15;

Vec3 outward(const Orbit& o) {
    const double level = std::cos(o.elevation_rad);
    return {level * std::sin(o.azimuth_rad), std::sin(o.elevation_rad), level * std::cos(o.azimuth_rad)};
}

Pose stageFromCamera(const Orbit& o) {
    return stageFromEyes(o.middle_m + o.distance_m * outward(o), o.middle_m);
}

}  // namespace

void turn(Orbit& o, double right, double up) {
    o.azimuth_rad = std::remainder(o.azimuth_rad - std::numbers::pi * right, 2.0 * std::numbers::pi);
    o.elevation_rad =
        std::clamp(o.elevation_rad - std::numbers::pi * up, kMinElevation_rad, kMaxElevation_rad);
}

void pan(Orbit& o, double right, double up) {
    const double height_m = 2.0 * o.distance_m * std::tan(kOrbitHalfHeight_rad);
    o.middle_m -= stageFromCamera(o).direction({height_m * right, height_m * up, 0.0});
}

void zoom(Orbit& o, double steps) {
    o.distance_m = std::clamp(o.distance_m * std::pow(kZoomStep, -steps), kMinDistance_m, kMaxDistance_m);
}

render::View orbitView(const Orbit& o, double aspect) {
    const float up = float(kOrbitHalfHeight_rad);
    const float right = float(std::atan(aspect * std::tan(kOrbitHalfHeight_rad)));
    return {stageFromCamera(o), -right, right, up, -up};
}

}  // namespace stylet::trainer
