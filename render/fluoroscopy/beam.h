// Geometry of the X-ray beam: from the focal spot to the pixels of a flat detector.
#pragma once

#include <optional>

#include "render/scene/scene.h"

namespace stylet::render {

// Dimensions of the mobile C-arm in the room (assets/generate/c_arm.py).
inline constexpr double kSourceToDetector_m = 1.100, kSourceToIsocentre_m = 0.720;

// Four lead blades and an optional iris. Distances from the detector's middle to the edges of the open area,
// measured on the detector. Right and up are as on the screen.
struct Collimation {
    double left_m = 0.15, right_m = 0.15, up_m = 0.15, down_m = 0.15;
    std::optional<double> iris_m = std::nullopt;  // radius
};

// Patient frame. The picture is seen from the detector toward the source, with the head at the top. If both
// angles of the C-arm are 0, the patient's left is on the right, as if the patient faced the viewer.
struct Beam {
    Vec3 source_m{0.0}, detector_m{0.0};               // focal spot, middle of the detector
    Vec3 right{-1.0, 0.0, 0.0}, down{0.0, 0.0, -1.0};  // unit vectors on the detector
};

// The axes of the isocentre's frame point to the right, up, and toward the head of a patient who lies
// straight on the table.
Beam makeBeam(const CArm&, const Pose& patient_from_isocentre);

// Centre of a pixel of a square detector with sides of `side_m` and `pixels` pixels per side. Row 0 is at the
// top.
Vec3 pixelAt(const Beam&, int column, int row, int pixels, double side_m);

// Area on the detector that blades and iris leave open, m2. Openings beyond the detector's edge do not count.
double openArea_m2(const Collimation&, double side_m);

// Open share of a pixel, 0 to 1. Edges are blurred over one pixel. `right_m` and `down_m` are measured from
// the middle of the detector.
double openShare(const Collimation&, double right_m, double down_m, double pixel_m);

}  // namespace stylet::render
