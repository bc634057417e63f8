// Geometry of the X-ray beam: from the focal spot to the pixels of a flat detector.
#pragma once

#include <optional>

#include "render/scene/scene.h"

namespace stylet::render {

// Dimensions of the mobile C-arm in the room (assets/generate/c_arm.py).
inline constexpr double kSourceToDetector_m = 1.100, kSourceToIsocentre_m = 0.720;

// Collimation by four lead blades and an optional iris: the open area, in metres on the detector from its
// middle. Right and up are those of the screen.
struct Collimation {
    double left_m = 0.15, right_m = 0.15, up_m = 0.15, down_m = 0.15;
    std::optional<double> iris_m = std::nullopt;  // radius
};

// Patient frame. The picture is seen from the detector toward the source, with the head at the top. At both
// angles 0 the patient's left is on the right, as if the patient faced the viewer.
struct Beam {
    Vec3 source_m{0.0}, detector_m{0.0};               // focal spot, middle of the detector
    Vec3 right{-1.0, 0.0, 0.0}, down{0.0, 0.0, -1.0};  // unit vectors on the detector
};

// `patient_from_isocentre`: with the C-arm at 0, its axes are those of a patient who lies straight.
Beam beamOf(const CArm&, const Pose& patient_from_isocentre);

// Middle of a pixel. Row 0 is the topmost of `pixels` rows on a side of `side_m`.
Vec3 pixelAt(const Beam&, int column, int row, int pixels, double side_m);

// Area on the detector that the blades leave open, m2. Openings beyond the detector's edge do not count.
double openArea_m2(const Collimation&, double side_m);

// Open share of a pixel, 0 to 1. The blades' edges are one pixel wide. `right_m` and `down_m` are measured
// from the middle of the detector.
double openShare(const Collimation&, double right_m, double down_m, double pixel_m);

}  // namespace stylet::render
