// Where the X-rays run: from the focal spot to the pixels of a flat detector.
#pragma once

#include <optional>

#include "render/scene.h"

namespace stylet::render {

// Of the mobile C-arm that stands in the room (assets/generate/c_arm.py).
inline constexpr double kSourceToDetector_m = 1.100, kSourceToIsocentre_m = 0.720;

// Four lead blades and, on request, an iris: what is left open, metres on the detector from its middle. Right
// and up as on the screen.
struct Collimation {
    double left_m = 0.15, right_m = 0.15, up_m = 0.15, down_m = 0.15;
    std::optional<double> iris_m = std::nullopt;  // radius
};

// Patient frame. The picture is seen from the detector toward the source, the head above: at both angles 0
// the patient's left is on the right, as if he faced the reader.
struct Beam {
    Vec3 source_m{0.0}, detector_m{0.0};               // focal spot, middle of the detector
    Vec3 right{-1.0, 0.0, 0.0}, down{0.0, 0.0, -1.0};  // unit, on the detector
};

// `patient_from_isocentre`: with the C-arm at 0, its axes are those of a patient who lies straight.
Beam beamOf(const CArm&, const Pose& patient_from_isocentre);

// The middle of a pixel; row 0 is the topmost of `pixels` on a side of `side_m`.
Vec3 pixelAt(const Beam&, int column, int row, int pixels, double side_m);

// Area on the detector that the blades leave open, m2: nothing that lies beyond its edge counts.
double openArea_m2(const Collimation&, double side_m);

// How much of a pixel is open, 0 to 1: the blades' edges are one pixel wide. `at_m`: from the middle of the
// detector, right and down.
double openShare(const Collimation&, double right_m, double down_m, double pixel_m);

}  // namespace stylet::render
