#include "render/fluoroscopy/exposure.h"

#include <algorithm>
#include <cmath>

namespace stylet::render {

double meteredTransmission(std::span<const float> metered) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const float path : metered)
        if (path > kMinTissuePath) sum += double(path), ++count;
    return count > 0 ? std::exp(-sum / double(count)) : 1.0;
}

Exposure computeExposure(double transmission, const Collimation& collimation, double side_m, int pixels,
                         double pulse_rate_hz, const DoseSettings& dose) {
    Exposure e;
    e.transmission = transmission;
    const double farther = kSourceToDetector_m / kSourceToReference_m;
    const double wanted_gy = dose.detector_kerma_gy / transmission * farther * farther;
    const double max_gy = std::min(dose.max_kerma_gy_per_s / pulse_rate_hz, dose.max_kerma_gy_per_pulse);
    const double min_gy = std::min(dose.min_kerma_gy_per_s / pulse_rate_hz, max_gy);
    e.at_limit = wanted_gy > max_gy;
    e.reference_kerma_gy = std::clamp(wanted_gy, min_gy, max_gy);
    const double at_detector_gy = e.reference_kerma_gy / (farther * farther);
    const double pixel_m = side_m / pixels;
    e.quanta_per_pixel = at_detector_gy * kPhotonsPerM2Gy * kDetectedShare * pixel_m * pixel_m;
    // Kerma falls with distance as the beam's area grows. Their product is the same at any distance.
    e.dose_area_gy_m2 = at_detector_gy * openArea_m2(collimation, side_m);
    return e;
}

}  // namespace stylet::render
