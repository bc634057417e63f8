// The ultrasound probe on the skin: a bar of proxies, how much of its face touches and how hard, and the
// parked probe, which rides the skin along its normal.
#pragma once

#include "haptics/pad.h"

namespace stylet::haptics {

struct ProbeSettings {
    int columns = 9, rows = 3;  // of proxies over the face
    double length_m = 0.060, width_m = 0.014;
    double curvature_m = 0.060;  // the convex probe's radius
    // Gel between: below the 0.2 that Derler and Gerhardt (2012) find to be the least on dry skin.
    PadSettings pad{.stiffest_n_per_m = 2000.0, .shear_n_per_m = 400.0, .friction = 0.1};
};

struct ProbeState {
    PadState pad;
    // Of the last step. A part of the face that does not touch shows nothing.
    double touching_share = 0.0;
    double pressure_pa = 0.0;  // mean over what touches
};

Pad probePad(const ProbeSettings&) noexcept;
// Haptics thread. noexcept, no allocation. `pad` is probePad() of the same settings; the tip is the middle of
// the face, +z of the tool out of the body, +x along the array.
ToolForce stepProbe(ProbeState&, const ProbeSettings&, const Pad& pad, const TouchMap&,
                    const patient::MotionModel&, const Pose& patient_from_tool,
                    const patient::Surrogate&) noexcept STYLET_NONBLOCKING;

// A probe let go of where it stands: it keeps its orientation and its depth in the skin, and goes up and down
// along the skin's normal of that moment.
struct SkinRider {
    Vec3 at_m{0.0};        // the middle of the face
    Vec3 outward{0.0};     // unit
    double level_m = 0.0;  // of the skin there
};
// Haptics thread, both. noexcept, no allocation.
// The frame of the tool as in stepProbe().
SkinRider parkOnSkin(const TouchMap&, const patient::MotionModel&, const patient::Surrogate&,
                     const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING;
// Returns how far the skin has taken it.
Vec3 rideSkin(SkinRider&, const TouchMap&, const patient::MotionModel&,
              const patient::Surrogate&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
