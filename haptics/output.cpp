#include "haptics/output.h"

#include <algorithm>
#include <cmath>

#include "haptics/hold.h"

namespace stylet::haptics {

namespace {

// What an unknown device is taken for: the Touch, the weakest of the profiles (3D Systems' data sheet).
constexpr double kWeakestForce_n = 3.3;
constexpr double kWeakestStiffness_n_per_m = 400.0;

double known(double value, double otherwise) noexcept {
    return std::isnan(value) ? otherwise : value;
}

bool isFinite(const Vec3& v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// The nearest vector no longer than `limit`.
Vec3 clampLength(const Vec3& v, double limit, bool& limited) noexcept {
    const double length = std::sqrt(glm::dot(v, v));
    if (length <= limit) return v;
    limited = true;
    return v * (limit / length);
}

}  // namespace

double worstTangent(const patient::TissueTable& table, const NeedleSettings& needle) noexcept {
    double worst = 0.0;
    for (const patient::TissueRow& row : table)
        worst = std::max(worst, (isRigid(row) ? 1.0 : 2.0 - needle.a1_share) * row.stiffness_n_per_m);
    return worst;
}

double outputGain(const DeviceProfile& profile, const OutputSettings& settings) noexcept {
    const double stiffness = known(profile.stiffness_n_per_m, kWeakestStiffness_n_per_m);
    const double force = known(profile.force_peak_n, kWeakestForce_n);
    return std::min({1.0, stiffness / settings.model_tangent_n_per_m, force / settings.model_force_n});
}

Vec3 stepOutput(OutputState& s, const OutputSettings& settings, const DeviceProfile& profile, double gain,
                const Vec3& force_n, double dt_s) noexcept {
    if (!isFinite(force_n)) s.faults |= kFaultNotFinite;
    const Vec3 wanted = (s.faults & kFaultsZeroForce) != 0 ? Vec3(0.0) : force_n;

    s.limited = false;
    const Vec3 change = clampLength(wanted - s.model_n, settings.rate_limit_n_per_s * dt_s, s.limited);
    s.model_n = s.limited ? s.model_n + change : wanted;
    const Vec3 modelled = clampLength(s.model_n, settings.model_force_n, s.limited);
    s.sent_n = clampLength(gain * modelled, known(profile.force_peak_n, kWeakestForce_n), s.limited);
    return s.sent_n;
}

}  // namespace stylet::haptics
