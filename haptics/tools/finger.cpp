#include "haptics/tools/finger.h"

namespace stylet::haptics {

Pad fingerPad(const FingerSettings& settings) noexcept {
    return roundPad(settings.points, settings.radius_m, settings.curvature_m);
}

ToolForce stepFinger(FingerState& s, const FingerSettings& settings, const Pad& pad, const TouchMap& map,
                     const patient::MotionModel& motion, const Pose& patient_from_tool,
                     const patient::Surrogate& breath) noexcept {
    return stepPad(s.pad, pad, settings.pad, map, motion, patient_from_tool, breath).force;
}

}  // namespace stylet::haptics
