#include "haptics/tools/finger.h"

namespace stylet::haptics {

Pad fingerPad(const FingerSettings& settings) noexcept {
    return roundPad(settings.points, settings.radius_m, settings.curvature_m);
}

ToolForce stepFinger(FingerState& s, const FingerSettings& settings, const Pad& pad,
                     const BreathingSkin& skin, const Pose& patient_from_tool) noexcept {
    return stepPad(s.pad, pad, settings.pad, skin, patient_from_tool).force;
}

}  // namespace stylet::haptics
