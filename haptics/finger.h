// The palpating finger: ribs are bumps, gaps between them yield. See pad.h for how it is computed.
#pragma once

#include "haptics/pad.h"

namespace stylet::haptics {

struct FingerSettings {
    // 7 to 30. The force is within 0.015 N of 300 points with 7, 0.005 N with 19 (bench haptics.contact); the
    // torque and a light touch, which few points meet, want the more.
    int points = 19;
    double radius_m = 0.006;     // of the pad: 1.1 cm^2 of an index finger
    double curvature_m = 0.020;  // of the pulp, flattened as it presses
    // Friction: dry skin, 0.2 and more, typically 0.5; Derler and Gerhardt, Tribol. Lett. 45:1, 2012.
    PadSettings pad{.stiffest_n_per_m = 2000.0, .shear_n_per_m = 300.0, .friction = 0.5};
};

struct FingerState {
    PadState pad;
};

Pad fingerPad(const FingerSettings&) noexcept;
// Haptics thread. noexcept, no allocation. `pad` is fingerPad() of the same settings; the tip is the middle
// of the pad, +z of the tool out of the body.
ToolForce stepFinger(FingerState&, const FingerSettings&, const Pad& pad, const TouchMap&,
                     const patient::MotionModel&, const Pose& patient_from_tool,
                     const patient::Surrogate&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
