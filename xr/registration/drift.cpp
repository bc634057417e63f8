#include "xr/registration/drift.h"

#include <array>
#include <cstdio>

namespace stylet::xr::registration {

Drift judgeDrift(const Stored& stored, std::span<const Pair> touched) {
    // 99th percentile of the length of a 3D normal error, in standard deviations per axis.
    constexpr double kLongest = 3.37;
    Drift drift;
    if (touched.empty()) {
        drift.what = "Nothing was touched.";
        return drift;
    }
    Vec3 sum(0.0);
    double squares = 0.0;
    for (const Pair& pair : touched) {
        const Vec3 by_device =
            stored.stage_from_device * (stored.scale * (pair.device_from_stylus * stored.stylus_from_tip_m));
        const Vec3 miss = pair.stage_from_grip * stored.grip_from_tip_m - by_device;
        sum += miss;
        squares += glm::dot(miss, miss);
    }
    const double n = double(touched.size());
    drift.moved_m = glm::length(sum / n);
    drift.allowed_m = kLongest * std::sqrt(stored.noise_m * stored.noise_m / n +
                                           stored.tre_worst_m * stored.tre_worst_m / 3.0);
    // A rotation about the centre of the touches leaves the mean error small, but increases the error of
    // each touch.
    const double spread_m = std::sqrt(squares / n);
    const double spread_allowed_m =
        kLongest * std::sqrt(stored.noise_m * stored.noise_m + stored.tre_worst_m * stored.tre_worst_m / 3.0);
    if (spread_m > spread_allowed_m && !(drift.moved_m > drift.allowed_m))
        drift.moved_m = spread_m, drift.allowed_m = spread_allowed_m;
    drift.holds = drift.moved_m <= drift.allowed_m;  // false for NaN
    std::array<char, 200> text{};
    std::snprintf(
        text.data(), text.size(),
        drift.holds ? "The device is still where it was: %.1f mm off, where up to %.1f are no surprise."
        : std::isfinite(drift.moved_m)
            ? "The device has moved by about %.1f mm (up to %.1f would be no surprise): register it again."
            : "What was touched is not a number.",
        1e3 * drift.moved_m, 1e3 * drift.allowed_m);
    drift.what = text.data();
    return drift;
}

}  // namespace stylet::xr::registration
