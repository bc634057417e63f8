#include "haptics/devices/falcon/falcon_kinematics.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

namespace stylet::haptics::falcon {

namespace {

// FalconGeometry.h, in metres, with the letters used there.
constexpr double kThigh_m = 0.060;          // a
constexpr double kShin_m = 0.1025;          // b
constexpr double kGripArm_m = 0.01443;      // c
constexpr double kElbows_m = 2 * 0.01125;   // d + e
constexpr double kGripShift_m = -0.025;     // f
constexpr double kPivotRadius_m = 0.0400;   // r
constexpr double kPivotShift_m = -0.02309;  // s
constexpr double kLeg_rad[3] = {7.0 * std::numbers::pi / 12.0, -std::numbers::pi / 12.0,
                                -9.0 * std::numbers::pi / 12.0};

constexpr double kOffset_rad = 35.0 * std::numbers::pi / 180.0;
constexpr double kRadiansPerCount = 2.0 * std::numbers::pi / 1280.0 * (0.01425 / 0.110);

constexpr double kTolerance_rad = 1e-9;
constexpr int kMaxNewtonSteps = 30;

// The grip as seen by one leg. The shin is a parallelogram. Rotated sideways by acos(side / b), it keeps the
// grip level and leaves a two-link arm in the leg's plane: the thigh and `shin_m`.
struct Leg {
    double cos_leg, sin_leg;
    double out_m, up_m;  // of the shin's end, in the plane, from the thigh's pivot
    double side_m;       // across the plane
    double shin_m;       // d(shin)/d(side) = -side / (shin - elbows)
    double angle_rad;    // of the thigh
};

// Empty if the leg cannot reach `p`.
std::optional<Leg> legAt(const Vec3& p, double leg_rad) noexcept {
    Leg l{};
    l.cos_leg = std::cos(leg_rad);
    l.sin_leg = std::sin(leg_rad);
    l.out_m = l.cos_leg * p.x + l.sin_leg * p.y - kPivotRadius_m + kGripArm_m;
    l.side_m = -l.sin_leg * p.x + l.cos_leg * p.y - kPivotShift_m + kGripShift_m;
    l.up_m = p.z;
    if (!(std::fabs(l.side_m) < kShin_m)) return std::nullopt;
    l.shin_m = kElbows_m + std::sqrt(kShin_m * kShin_m - l.side_m * l.side_m);

    // Law of cosines. The other root has the elbow bent inward.
    const double reach2 = l.out_m * l.out_m + l.up_m * l.up_m, reach = std::sqrt(reach2);
    const double along = (reach2 + kThigh_m * kThigh_m - l.shin_m * l.shin_m) / (2.0 * kThigh_m);
    if (!(std::fabs(along) < reach)) return std::nullopt;
    l.angle_rad = std::atan2(l.up_m, l.out_m) - std::acos(along / reach);
    return l;
}

// q = (out, up) - a (cos t, sin t) is the shin in the plane, with |q| = shin(side). Differentiated: a (q x
// n) dt = q . d(out, up) + shin side / (shin - elbows) d(side), where n is the thigh's direction.
std::optional<Vec3> angleGradient(const Leg& l) noexcept {
    const double cos_t = std::cos(l.angle_rad), sin_t = std::sin(l.angle_rad);
    const double q_out = l.out_m - kThigh_m * cos_t, q_up = l.up_m - kThigh_m * sin_t;
    const double lever = kThigh_m * (q_up * cos_t - q_out * sin_t);
    if (!(std::fabs(lever) > 1e-6)) return std::nullopt;
    const double q_side = l.shin_m * l.side_m / (l.shin_m - kElbows_m);
    return Vec3(q_out * l.cos_leg - q_side * l.sin_leg, q_out * l.sin_leg + q_side * l.cos_leg, q_up) / lever;
}

std::optional<Vec3> solveNewton(const Angles& angles_rad, Vec3 p) noexcept {
    for (int i = 0; i < kMaxNewtonSteps; ++i) {
        const auto here = anglesAt(p);
        const auto jacobian = jacobianAt(p);
        if (!here || !jacobian) return std::nullopt;
        const Vec3 miss = angles_rad - *here;
        if (std::max({std::fabs(miss.x), std::fabs(miss.y), std::fabs(miss.z)}) < kTolerance_rad) return p;
        Vec3 step = glm::inverse(*jacobian) * miss;
        // Far from the solution the full step may leave the workspace.
        while (!anglesAt(p + step)) {
            step *= 0.5;
            if (!(glm::dot(step, step) > 1e-18)) return std::nullopt;
        }
        p += step;
    }
    return std::nullopt;
}

}  // namespace

double radiansFromCounts(double counts) noexcept {
    return counts * kRadiansPerCount + kOffset_rad;
}

double countsFromRadians(double radians) noexcept {
    return (radians - kOffset_rad) / kRadiansPerCount;
}

Angles anglesFromCounts(const Counts& n) noexcept {
    return {radiansFromCounts(n[0]), radiansFromCounts(n[1]), radiansFromCounts(n[2])};
}

std::optional<Angles> anglesAt(const Vec3& grip_m) noexcept {
    Angles angles{0.0};
    for (int i = 0; i < 3; ++i) {
        const auto leg = legAt(grip_m, kLeg_rad[i]);
        if (!leg) return std::nullopt;
        angles[i] = leg->angle_rad;
    }
    return angles;
}

std::optional<glm::dmat3> jacobianAt(const Vec3& grip_m) noexcept {
    glm::dmat3 rows(0.0);
    for (int i = 0; i < 3; ++i) {
        const auto leg = legAt(grip_m, kLeg_rad[i]);
        const auto gradient = leg ? angleGradient(*leg) : std::nullopt;
        if (!gradient) return std::nullopt;
        rows[i] = *gradient;
    }
    return glm::transpose(rows);
}

std::optional<Vec3> gripFromAngles(const Angles& angles_rad, const Vec3& near_m) noexcept {
    if (const auto grip = solveNewton(angles_rad, near_m)) return grip;
    return solveNewton(angles_rad, kCentre_m);
}

std::optional<Vec3> computeTorques(const Vec3& force_n, const Vec3& grip_m) noexcept {
    const auto jacobian = jacobianAt(grip_m);
    if (!jacobian) return std::nullopt;
    return glm::transpose(glm::inverse(*jacobian)) * force_n;
}

}  // namespace stylet::haptics::falcon
