#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "haptics/tools/device.h"

namespace stylet::haptics {

namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr Vec3 kX{1.0, 0.0, 0.0}, kY{0.0, 1.0, 0.0}, kZ{0.0, 0.0, 1.0};

// Body angle divided by motor angle.
double ratio(const WoodenModel& m, int body) noexcept {
    const std::size_t i = std::size_t(body);
    return (m.motor_aligned[i] ? -1.0 : 1.0) * m.capstan_diameter_m[i] / m.body_diameter_m[i];
}

double bodyRadPerCount(const WoodenModel& m, int body) noexcept {
    return kTurn_rad / m.counts_per_turn[std::size_t(body)] * ratio(m, body);
}

// Share of the force's current that fits within the limit in addition to the holding current.
double shareThatFits(double hold_a, double force_a) noexcept {
    if (std::fabs(hold_a + force_a) <= kMaxCurrent_a) return 1.0;
    const double room_a = (force_a > 0.0 ? kMaxCurrent_a : -kMaxCurrent_a) - hold_a;
    return std::clamp(room_a / force_a, 0.0, 1.0);
}

}  // namespace

Vec3 armAngles_rad(const WoodenModel& m, const ArmCounts& counts) noexcept {
    return {counts[0] * bodyRadPerCount(m, 0), counts[1] * bodyRadPerCount(m, 1),
            counts[2] * bodyRadPerCount(m, 2)};
}

Vec3 armPosition_m(const WoodenModel& m, const Vec3& t) noexcept {
    const double reach = m.length_m[1] * std::sin(t.y) + m.length_m[2] * std::sin(t.z);
    return Vec3{std::cos(t.x) * reach, std::sin(t.x) * reach,
                m.length_m[0] + m.length_m[1] * std::cos(t.y) - m.length_m[2] * std::cos(t.z)} -
           m.workspace_origin_m;
}

glm::dmat3 armJacobian(const WoodenModel& m, const Vec3& t) noexcept {
    const double ca = std::cos(t.x), sa = std::sin(t.x), b = m.length_m[1], c = m.length_m[2];
    const double reach = b * std::sin(t.y) + c * std::sin(t.z);
    return {Vec3{-sa * reach, ca * reach, 0.0},
            b * Vec3{ca * std::cos(t.y), sa * std::cos(t.y), -std::sin(t.y)},
            c * Vec3{ca * std::cos(t.z), sa * std::cos(t.z), std::sin(t.z)}};
}

Quat armRotation(const WoodenModel& m, const Vec3& t, const ArmCounts& counts) noexcept {
    if (!m.hasWrist()) return {1.0, 0.0, 0.0, 0.0};
    // The board numbers the wrist's encoders from the stylus inward: f belongs to the first wrist body.
    const auto wrist_rad = [&](std::size_t body, std::size_t encoder) {
        return (m.wrist_aligned[body] ? 1.0 : -1.0) * counts[encoder] * kTurn_rad /
               m.counts_per_turn[3 + body];
    };
    return glm::angleAxis(t.x, kZ) * glm::angleAxis(0.25 * kTurn_rad - t.z, kY) *
           glm::angleAxis(wrist_rad(0, 5), kX) * glm::angleAxis(wrist_rad(1, 4), kY) *
           glm::angleAxis(wrist_rad(2, 3), kX);
}

// Gradient of g (m_b r_b cos b + m_c (L_b cos b - r_c cos c)).
Vec3 armGravityTorque_n_m(const WoodenModel& m, const Vec3& t) noexcept {
    return m.gravity_m_s2 *
           Vec3{0.0, -(m.mass_kg[0] * m.centre_of_mass_m[0] + m.mass_kg[1] * m.length_m[1]) * std::sin(t.y),
                m.mass_kg[1] * m.centre_of_mass_m[1] * std::sin(t.z)};
}

ArmCurrents armCurrents(const WoodenModel& m, const Vec3& angles_rad, const Vec3& force_n) noexcept {
    const bool finite = isFinite(force_n);
    const Vec3 force_torque = finite ? glm::transpose(armJacobian(m, angles_rad)) * force_n : Vec3{0.0};
    const Vec3 hold_torque = armGravityTorque_n_m(m, angles_rad);
    Vec3 hold_a{0.0}, force_a{0.0};
    double share = 1.0;
    for (int i = 0; i < 3; ++i) {
        const double a_per_n_m = ratio(m, i) / m.torque_constant_n_m_per_a[std::size_t(i)];
        hold_a[i] = std::clamp(hold_torque[i] * a_per_n_m, -kMaxCurrent_a, kMaxCurrent_a);
        force_a[i] = force_torque[i] * a_per_n_m;
        share = std::min(share, shareThatFits(hold_a[i], force_a[i]));
    }
    ArmCurrents currents{hold_a + share * force_a, share < 1.0};
    for (int i = 0; i < 3; ++i)
        currents.motor_a[i] = std::clamp(currents.motor_a[i], -kMaxCurrent_a, kMaxCurrent_a);
    return currents;
}

double armResolution_m(const WoodenModel& m, const Vec3& angles_rad) noexcept {
    const glm::dmat3 jacobian = armJacobian(m, angles_rad);
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
        const Vec3 step_m = jacobian[i] * bodyRadPerCount(m, i);
        sum += glm::dot(step_m, step_m);
    }
    return std::sqrt(sum);
}

}  // namespace stylet::haptics
