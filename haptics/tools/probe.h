// The ultrasound probe on the skin, a bar of proxies. Computes the share of its face in contact and the mean
// pressure. A parked probe rides the skin along its normal.
#pragma once

#include <optional>

#include "haptics/tools/pad.h"

namespace stylet::haptics {

struct ProbeSettings {
    int columns = 9, rows = 3;  // grid of proxies on the face
    double length_m = 0.060, width_m = 0.014;
    double curvature_m = 0.060;  // radius of the convex probe
    // Gel lies between probe and skin, so the friction is below 0.2, the lowest value that Derler and
    // Gerhardt (2012) found on dry skin.
    PadSettings pad{.max_stiffness_n_per_m = 2000.0, .shear_n_per_m = 400.0, .friction = 0.1};
};

struct ProbeState {
    PadState pad;
    // Of the last step. The part of the face without contact shows no image.
    double touching_share = 0.0;
    double pressure_pa = 0.0;  // mean over the touching part
};

Pad probePad(const ProbeSettings&) noexcept;

// The picture's scan lines start on the face and run along its normals: the lines of a curved face form a
// fan, those of a flat face are almost parallel. Frame of the picture: origin in the centre of the face, +x
// along the array, +z into the body (kStylusFromProbe in toolbox.h). The plane of the picture is y = 0.
//
// Angle between the middle and the outermost scan line.
double fanHalfAngle_rad(const ProbeSettings&) noexcept;
// The point of the face at which the scan line through `p_m` starts. Ignores the distance of `p_m` from the
// plane. Nothing if no scan line reaches the point. noexcept, no allocation.
std::optional<Vec3> scanLineStart(const ProbeSettings&, const Vec3& p_m) noexcept;

// Haptics thread. noexcept, no allocation. `pad` is probePad() of the same settings. The tool's tip is the
// centre of the face; +z points out of the body and +x along the array.
ToolForce stepProbe(ProbeState&, const ProbeSettings&, const Pad& pad, const BreathingSkin&,
                    const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING;

// A parked probe. It keeps its orientation and its depth in the skin. It moves up and down along the skin
// normal found when it was parked.
struct SkinFollower {
    Vec3 at_m{0.0};        // centre of the face
    Vec3 outward{0.0};     // unit
    double level_m = 0.0;  // skin level (signed distance) there
};
// Both functions: haptics thread. noexcept, no allocation.
// Parks the probe. The tool frame is that of stepProbe().
SkinFollower parkOnSkin(const BreathingSkin&, const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING;
// Moves the probe with the skin for one tick. Returns its displacement.
Vec3 followSkin(SkinFollower&, const BreathingSkin&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
