#include "haptics/devices/spacemouse/rate_control.h"

#include <algorithm>
#include <cmath>

namespace stylet::haptics {

double rateShare(double axis, const RateSettings& settings) noexcept {
    const double pushed = std::min(std::fabs(axis) / settings.full_scale, 1.0);
    // NaN counts as at rest.
    if (!(pushed > settings.dead_zone)) return 0.0;
    const double share = (pushed - settings.dead_zone) / (1.0 - settings.dead_zone);
    return std::copysign(share * share, axis);
}

void stepRate(Pose& pose, const std::array<double, 6>& axes, const RateSettings& settings,
              double dt_s) noexcept {
    if (!(dt_s > 0.0)) return;
    const double step_s = std::min(dt_s, settings.max_step_s);
    const auto share = [&](std::size_t axis) { return rateShare(axes[axis], settings); };

    const Vec3 moved_m = settings.speed_m_s * step_s * Vec3{share(0), share(1), share(2)};
    const Vec3 there_m = pose.position_m + moved_m;
    const double away_m = std::sqrt(glm::dot(there_m, there_m));
    pose.position_m = away_m > settings.reach_m ? there_m * (settings.reach_m / away_m) : there_m;

    // Half the rotation as a vector: exact to third order for the few milliradians of a step.
    const Vec3 half_rad = 0.5 * settings.turn_rad_s * step_s * Vec3{share(3), share(4), share(5)};
    const Quat turned = Quat{1.0, half_rad.x, half_rad.y, half_rad.z} * pose.rotation;
    pose.rotation = turned * (1.0 / std::sqrt(glm::dot(turned, turned)));
}

}  // namespace stylet::haptics
