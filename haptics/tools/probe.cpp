#include "haptics/tools/probe.h"

#include <algorithm>
#include <cmath>

namespace stylet::haptics {

using patient::MotionModel;
using patient::Surrogate;

namespace {

constexpr int kNewtonSteps = 2;            // per tick: the skin moves by about 20 um in one
constexpr double kFarthestStep_m = 0.002;  // largest single Newton step
constexpr double kSteepness = 0.5;         // smallest level slope that is trusted

}  // namespace

Pad probePad(const ProbeSettings& settings) noexcept {
    return barPad(settings.columns, settings.rows, settings.length_m, settings.width_m, settings.curvature_m);
}

ToolForce stepProbe(ProbeState& s, const ProbeSettings& settings, const Pad& pad, const TouchMap& map,
                    const MotionModel& motion, const Pose& patient_from_tool,
                    const Surrogate& breath) noexcept {
    const PadContact contact = stepPad(s.pad, pad, settings.pad, map, motion, patient_from_tool, breath);
    s.touching_share = double(contact.touching) / pad.count;
    s.pressure_pa = contact.touching > 0 ? contact.normal_n / (contact.touching * pad.point_area_m2) : 0.0;
    return contact.force;
}

SkinRider parkOnSkin(const TouchMap& map, const MotionModel& motion, const Surrogate& breath,
                     const Pose& patient_from_tool) noexcept {
    const Vec3 at_m = patient_from_tool.position_m;
    Carried toReference = carriedAt(motion, breath, at_m);
    addSlope(toReference, motion, breath, glm::mat3_cast(patient_from_tool.rotation));
    const TouchPoint t = touchAt(map, toReference.at_reference_m);
    const Vec3 outward = glm::transpose(toReference.slope) * t.level_slope;
    const double length = std::sqrt(glm::dot(outward, outward));
    return {at_m, length > 0.0 ? outward / length : Vec3(0.0), t.level_m};
}

Vec3 rideSkin(SkinRider& rider, const TouchMap& map, const MotionModel& motion,
              const Surrogate& breath) noexcept {
    const Vec3 before_m = rider.at_m;
    for (int i = 0; i < kNewtonSteps; ++i) {
        const TouchPoint t = touchAt(map, patient::referenceFromDeformed(motion, breath, rider.at_m));
        const double slope = std::max(glm::dot(t.level_slope, rider.outward), kSteepness);
        const double up_m =
            std::clamp((rider.level_m - t.level_m) / slope, -kFarthestStep_m, kFarthestStep_m);
        rider.at_m += up_m * rider.outward;
    }
    return rider.at_m - before_m;
}

}  // namespace stylet::haptics
