// The palpating finger: ribs feel like bumps, and the gaps between them yield. pad.h computes the contact.
#pragma once

#include "haptics/tools/pad.h"

namespace stylet::haptics {

struct FingerSettings {
    // 7 to 30. Compared with 300 points, the force error is below 0.015 N with 7 points and 0.005 N with 19
    // (bench haptics.contact). More points are needed for the torque and for a light touch, where few
    // points are in contact.
    int points = 19;
    double radius_m = 0.006;     // pad radius: 1.1 cm^2 of an index finger
    double curvature_m = 0.020;  // of the fingertip, flattened under load
    // Friction on dry skin is at least 0.2, typically 0.5 (Derler and Gerhardt, Tribol. Lett. 45:1, 2012).
    PadSettings pad{.max_stiffness_n_per_m = 2000.0, .shear_n_per_m = 300.0, .friction = 0.5};
};

struct FingerState {
    PadState pad;
};

inline Pad fingerPad(const FingerSettings& s) noexcept {
    return roundPad(s.points, s.radius_m, s.curvature_m);
}
// Haptics thread. noexcept, no allocation. `pad` is fingerPad() of the same settings. The tool's tip is the
// centre of the pad; +z points out of the body.
inline ToolForce stepFinger(FingerState& s, const FingerSettings& settings, const Pad& pad,
                            const BreathingSkin& skin,
                            const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING {
    return stepPad(s.pad, pad, settings.pad, skin, patient_from_tool).force;
}

}  // namespace stylet::haptics
