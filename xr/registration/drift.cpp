#include "xr/registration/drift.h"

#include <fmt/core.h>

namespace stylet::xr::registration {

Drift checkDrift(const StoredRegistration& stored, std::span<const Pair> touched) {
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
    // If the device was rotated about the centre of the touches, the mean error is small, but the error of
    // each touch is large.
    const double spread_m = std::sqrt(squares / n);
    const double spread_allowed_m =
        kLongest * std::sqrt(stored.noise_m * stored.noise_m + stored.tre_worst_m * stored.tre_worst_m / 3.0);
    if (spread_m > spread_allowed_m && !(drift.moved_m > drift.allowed_m))
        drift.moved_m = spread_m, drift.allowed_m = spread_allowed_m;
    drift.valid = drift.moved_m <= drift.allowed_m;  // false for NaN
    const double moved_mm = 1e3 * drift.moved_m, allowed_mm = 1e3 * drift.allowed_m;
    if (!std::isfinite(drift.moved_m))
        drift.what = "What was touched is not a number.";
    else if (drift.valid)
        drift.what = fmt::format(
            "The device is still where it was: {:.1f} mm off, where up to {:.1f} are no surprise.", moved_mm,
            allowed_mm);
    else
        drift.what = fmt::format(
            "The device has moved by about {:.1f} mm (up to {:.1f} would be no surprise): register it again.",
            moved_mm, allowed_mm);
    return drift;
}

}  // namespace stylet::xr::registration
