#include "haptics/tools/pad.h"
#include "base/hash.h"
#include "base/transcendental.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace stylet::haptics {

namespace {

constexpr double kGoldenAngle_rad = 2.39996322972865332;
constexpr double kLevelSlope = 1.5;  // largest slope of the smoothed distance

double capHeight(double from_axis_m, double curvature_m) noexcept {
    const double square = curvature_m * curvature_m - from_axis_m * from_axis_m;
    return curvature_m - std::sqrt(std::max(square, 0.0));
}

// Divides the area among the points and centres them on the axis, so that a flat pad feels no torque.
void finishPad(Pad& pad, double area_m2) noexcept {
    pad.point_area_m2 = area_m2 / pad.count;
    Vec3 middle_m(0.0);
    for (int i = 0; i < pad.count; ++i)
        middle_m += pad.points_m[std::size_t(i)] / double(pad.count);
    for (int i = 0; i < pad.count; ++i)
        pad.points_m[std::size_t(i)] -= Vec3(middle_m.x, middle_m.y, 0.0);
    for (int i = 0; i < pad.count; ++i)
        pad.reach_m = std::max(pad.reach_m, glm::length(pad.points_m[std::size_t(i)]));
}

}  // namespace

Pad roundPad(int count, double radius_m, double curvature_m) noexcept {
    assert(count >= 1 && count <= kMaxPadPoints);
    Pad pad;
    pad.count = count;
    for (int i = 0; i < count; ++i) {
        const double r_m = radius_m * std::sqrt((i + 0.5) / count), angle_rad = kGoldenAngle_rad * i;
        pad.points_m[std::size_t(i)] = {r_m * detCos(angle_rad), r_m * detSin(angle_rad),
                                        capHeight(r_m, curvature_m)};
    }
    finishPad(pad, std::numbers::pi * radius_m * radius_m);
    return pad;
}

Pad barPad(int columns, int rows, double length_m, double width_m, double curvature_m) noexcept {
    assert(columns * rows >= 1 && columns * rows <= kMaxPadPoints);
    Pad pad;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const double x_m = length_m * ((column + 0.5) / columns - 0.5);
            const double y_m = width_m * ((row + 0.5) / rows - 0.5);
            pad.points_m[std::size_t(pad.count++)] = {x_m, y_m, capHeight(x_m, curvature_m)};
        }
    finishPad(pad, length_m * width_m);
    return pad;
}

PadContact stepPad(PadState& s, const Pad& pad, const PadSettings& settings, const BreathingSkin& skin,
                   const Pose& patient_from_tool) noexcept {
    const Mat3 frame = glm::mat3_cast(patient_from_tool.rotation);
    const Vec3 tip_m = patient_from_tool.position_m;
    PadContact contact;
    if (s.primed) contact.force.tissue_moved_m = skinDisplacement(skin, s.breath, s.skin_reference_m);
    contact.force.event = !s.primed;

    // Evaluate the breathing motion at the skin point found in the last step. The tip itself may be pressed
    // in as deep as organs that slide independently of the skin.
    LocalBreathingMap toReference = breathingMapAt(skin, tip_m + s.depth_m * s.outward);
    TouchPoint at_tip = touchAt(skin.map, toReference(tip_m));
    const bool near = at_tip.level_m < kLevelSlope * pad.reach_m;
    if (near) {
        addSlope(toReference, skin, frame);
        if (s.depth_m > 0.0) at_tip = touchAt(skin.map, toReference(tip_m));
    }
    const Mat3 back = glm::transpose(toReference.slope);
    const double stiffest_n_per_m3 = settings.max_stiffness_n_per_m / (pad.count * pad.point_area_m2);
    const double shear_n_per_m = settings.shear_n_per_m / pad.count;
    std::uint32_t touching = 0;
    for (int i = 0; near && i < pad.count; ++i) {
        const Vec3 arm_m = frame * pad.points_m[std::size_t(i)];
        const Vec3 point_m = toReference(tip_m + arm_m);
        const TouchPoint t = touchAt(skin.map, point_m);
        if (!(t.level_m < 0.0)) continue;
        const std::uint32_t bit = 1u << i;
        touching |= bit;
        Vec3& proxy_m = s.proxy_reference_m[std::size_t(i)];
        if (!(s.touching & bit)) proxy_m = point_m;

        const SkinPressure p = computePressure(t, stiffest_n_per_m3);
        const double normal_n = p.pressure_pa * pad.point_area_m2;
        const Vec3 normal = unitOr(t.level_slope, Vec3(0.0));
        Vec3 stretch_m;
        const double most_m = shear_n_per_m > 0.0 ? settings.friction * normal_n / shear_n_per_m : 0.0;
        contact.slipping += dragProxy(proxy_m, point_m, normal, most_m, stretch_m);

        const Vec3 force_n = back * (p.push_n_per_m2 * pad.point_area_m2 - shear_n_per_m * stretch_m);
        contact.force.force_n += force_n;
        contact.force.torque_n_m += glm::cross(arm_m, force_n);
        contact.force.energy_j +=
            p.energy_j_per_m2 * pad.point_area_m2 + 0.5 * shear_n_per_m * glm::dot(stretch_m, stretch_m);
        contact.normal_n += normal_n;
        contact.max_depth_m = std::max(contact.max_depth_m, -t.level_m);
        ++contact.touching;
    }
    s.touching = touching;
    s.outward = unitOr(back * at_tip.level_slope, Vec3(0.0));
    s.depth_m = std::clamp(-at_tip.level_m, 0.0, kDeepestTip_m);
    s.skin_reference_m = toReference(tip_m + s.depth_m * s.outward);
    s.breath = skin.breath;
    s.primed = true;
    return contact;
}

void hashPad(StateHash& hash, const PadState& s) noexcept {
    hash.add(std::uint64_t(s.touching) | std::uint64_t(s.primed) << 32);
    for (std::size_t i = 0; i < std::size_t(kMaxPadPoints); ++i)
        if (s.touching >> i & 1u) hash.add(s.proxy_reference_m[i]);
    hash.add(s.skin_reference_m, s.outward, s.depth_m);
    patient::hashSurrogate(hash, s.breath);
}

}  // namespace stylet::haptics
