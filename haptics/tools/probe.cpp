#include "haptics/tools/probe.h"

#include <algorithm>
#include <cmath>

namespace stylet::haptics {

namespace {

constexpr int kNewtonSteps = 2;            // per tick: the skin moves by about 20 um in one
constexpr double kFarthestStep_m = 0.002;  // largest single Newton step
constexpr double kSteepness = 0.5;         // smallest level slope that is trusted

}  // namespace

Pad probePad(const ProbeSettings& settings) noexcept {
    return barPad(settings.columns, settings.rows, settings.length_m, settings.width_m, settings.curvature_m);
}

double fanHalfAngle_rad(const ProbeSettings& settings) noexcept {
    return std::asin(std::min(0.5 * settings.length_m / settings.curvature_m, 1.0));
}

std::optional<Vec3> scanLineStart(const ProbeSettings& settings, const Vec3& p_m) noexcept {
    const Vec3 centre(0.0, 0.0, -settings.curvature_m);
    const Vec3 line = Vec3(p_m.x, 0.0, p_m.z) - centre;
    const double length_m = glm::length(line);
    // Written so that NaN is refused.
    if (!(length_m >= settings.curvature_m)) return std::nullopt;
    if (!(std::fabs(std::atan2(line.x, line.z)) <= fanHalfAngle_rad(settings))) return std::nullopt;
    return centre + line * (settings.curvature_m / length_m);
}

ToolForce stepProbe(ProbeState& s, const ProbeSettings& settings, const Pad& pad, const BreathingSkin& skin,
                    const Pose& patient_from_tool) noexcept {
    const PadContact contact = stepPad(s.pad, pad, settings.pad, skin, patient_from_tool);
    s.touching_share = double(contact.touching) / pad.count;
    s.pressure_pa = contact.touching > 0 ? contact.normal_n / (contact.touching * pad.point_area_m2) : 0.0;
    return contact.force;
}

SkinFollower parkOnSkin(const BreathingSkin& skin, const Pose& patient_from_tool) noexcept {
    const Vec3 at_m = patient_from_tool.position_m;
    LocalBreathingMap toReference = breathingMapAt(skin, at_m);
    addSlope(toReference, skin, glm::mat3_cast(patient_from_tool.rotation));
    const TouchPoint t = touchAt(skin.map, toReference.at_reference_m);
    return {at_m, unitOr(glm::transpose(toReference.slope) * t.level_slope, Vec3(0.0)), t.level_m};
}

Vec3 followSkin(SkinFollower& follower, const BreathingSkin& skin) noexcept {
    const Vec3 before_m = follower.at_m;
    for (int i = 0; i < kNewtonSteps; ++i) {
        const TouchPoint t =
            touchAt(skin.map, patient::referenceFromDeformed(skin.motion, skin.breath, follower.at_m));
        const double slope = std::max(glm::dot(t.level_slope, follower.outward), kSteepness);
        const double up_m =
            std::clamp((follower.level_m - t.level_m) / slope, -kFarthestStep_m, kFarthestStep_m);
        follower.at_m += up_m * follower.outward;
    }
    return follower.at_m - before_m;
}

}  // namespace stylet::haptics
