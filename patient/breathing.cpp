// Based on Wilms et al. 2014 (surrogate regression, stationary velocity fields). Hashed: double precision, no
// libm transcendental.
#include "patient/breathing.h"

#include <algorithm>
#include <limits>

namespace stylet::patient {
namespace {

constexpr int kFlowSteps = 4;

// C1 from 0 at `from` to 1 at `to`.
double smoothStep(double from, double to, double x) noexcept {
    const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

double bump(const BreathingModel& m, double z) noexcept {
    if (z <= m.z_low_m || z >= m.z_high_m) return 0.0;
    if (z < m.z_full_low_m) return smoothStep(m.z_low_m, m.z_full_low_m, z);
    if (z > m.z_full_high_m) return 1.0 - smoothStep(m.z_full_high_m, m.z_high_m, z);
    return 1.0;
}

// exp of the stationary field travel * bump(z): midpoint steps over unit time.
double flow(const BreathingModel& m, double travel_m, double z) noexcept {
    constexpr double kStep = 1.0 / kFlowSteps;
    for (int i = 0; i < kFlowSteps; ++i) {
        const double middle = z + 0.5 * kStep * travel_m * bump(m, z);
        z += kStep * travel_m * bump(m, middle);
    }
    return z;
}

// Travel of the inside, relative to the breath of the CT.
double travel(const BreathingModel& m, const Surrogate& now) noexcept {
    return m.a1_m * (now.v - m.reference.v) + m.a2_m_s * (now.rate_per_s - m.reference.rate_per_s);
}

bool inCavityRange(const BreathingModel& m, double z) noexcept {
    return !m.cavity.empty() && z >= m.cavity.front().z_m && z <= m.cavity.back().z_m;
}

CavityKnot ellipseAt(const BreathingModel& m, double z) noexcept {
    const auto above = std::upper_bound(m.cavity.begin(), m.cavity.end(), z,
                                        [](double value, const CavityKnot& k) { return value < k.z_m; });
    if (above == m.cavity.begin()) return m.cavity.front();
    if (above == m.cavity.end()) return m.cavity.back();
    const CavityKnot &a = *(above - 1), &b = *above;
    const double s = (z - a.z_m) / (b.z_m - a.z_m);
    return {z, a.x_m + s * (b.x_m - a.x_m), a.y_m + s * (b.y_m - a.y_m), a.rx_m + s * (b.rx_m - a.rx_m),
            a.ry_m + s * (b.ry_m - a.ry_m)};
}

// Moves p by the field of its side. Both fields keep rho, so a point and its image are on the same side:
// trying the inside and testing the pre-image is the same test as that of p itself.
Vec3 move(const BreathingModel& m, double inside_travel_m, const Vec3& p) noexcept {
    if (inside_travel_m == 0.0 || p.z <= m.z_low_m || p.z >= m.z_high_m || !inCavityRange(m, p.z)) return p;
    const CavityKnot from = ellipseAt(m, p.z);
    const double u = (p.x - from.x_m) / from.rx_m, w = (p.y - from.y_m) / from.ry_m;
    const double rho = std::sqrt(u * u + w * w);
    const double share = rho < 1.0 ? 1.0 : m.outside_share * outsideFade(m, rho);
    if (share == 0.0) return p;
    const double z = flow(m, share * inside_travel_m, p.z);
    const CavityKnot to = ellipseAt(m, z);
    return {to.x_m + u * to.rx_m, to.y_m + w * to.ry_m, z};
}

}  // namespace

double outsideFade(const BreathingModel& m, double rho) noexcept {
    if (rho <= 1.0) return 1.0;
    return rho >= m.fade_rho ? 0.0 : 1.0 - smoothStep(1.0, m.fade_rho, rho);
}

double cavityRho(const BreathingModel& m, const Vec3& p) noexcept {
    if (!inCavityRange(m, p.z)) return std::numeric_limits<double>::infinity();
    const CavityKnot k = ellipseAt(m, p.z);
    const double u = (p.x - k.x_m) / k.rx_m, w = (p.y - k.y_m) / k.ry_m;
    return std::sqrt(u * u + w * w);
}

Vec3 deformedFromReference(const BreathingModel& m, const Surrogate& now, const Vec3& reference_m) noexcept {
    return move(m, travel(m, now), reference_m);
}

Vec3 referenceFromDeformed(const BreathingModel& m, const Surrogate& now, const Vec3& deformed_m) noexcept {
    return move(m, -travel(m, now), deformed_m);
}

BreathingTable breathingTable(const BreathingModel& m, const Surrogate& now, int entries) {
    const double back_m = -travel(m, now);
    if (m.cavity.empty() || back_m == 0.0 || entries < 2) return {};
    BreathingTable table{m.z_low_m, (m.z_high_m - m.z_low_m) / (entries - 1), {}, {}};
    for (int i = 0; i < entries; ++i) {
        const double z = table.z_begin_m + i * table.dz_m;
        table.inside_reference_z_m.push_back(float(flow(m, back_m, z)));
        table.outside_reference_z_m.push_back(float(flow(m, m.outside_share * back_m, z)));
    }
    return table;
}

}  // namespace stylet::patient
