#include "patient/contrast/anaesthetic.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace stylet::patient {

namespace {

constexpr double kUndiluted_m3 = 0.3e-6;  // a smaller depot is diluted and numbs in proportion to its volume

}  // namespace

double depotRadius_m(double volume_m3) noexcept {
    constexpr double kBall = 4.18879020478639;  // 4 pi / 3
    return std::cbrt(std::max(0.0, volume_m3) / kBall);
}

void Anaesthetic::step(const AnaestheticInput& input, double dt_s) {
    if (!(input.rate_m3_per_s > 0.0)) return;
    const double amount_m3 = std::min(input.rate_m3_per_s, settings_.max_m3_per_s) * dt_s;
    const Tissue kind = input.tissue == Tissue::liver ? Tissue::liver : Tissue::soft;
    volumes_.injected_m3 += amount_m3;
    if (input.tissue == Tissue::vessel)
        volumes_.vessels_m3 += amount_m3;
    else if (input.tissue != Tissue::air && input.tissue != Tissue::duct &&
             addToStains(depots_, {1.0, settings_.new_place_m}, kind, input.tip_reference_m, amount_m3))
        volumes_.tissue_m3 += amount_m3;
    else
        volumes_.lost_m3 += amount_m3;
    hash_.add(input.tip_reference_m);
    hash_.add(std::uint64_t(input.tissue));
    hash_.add(amount_m3);
}

double Anaesthetic::numbness(const Vec3& reference_m) const noexcept {
    double most = 0.0;
    for (const Stain& depot : depots_) {
        const double numb_m = depotRadius_m(depot.volume_m3 / settings_.soaked_share);
        if (!(numb_m > 0.0)) continue;
        const double beyond = glm::distance(reference_m, depot.centre_m) / numb_m - 1.0;
        const double strength = std::min(1.0, depot.volume_m3 / kUndiluted_m3);
        most = std::max(most, strength * std::clamp(1.0 - beyond / settings_.fade_share, 0.0, 1.0));
    }
    return most;
}

}  // namespace stylet::patient
