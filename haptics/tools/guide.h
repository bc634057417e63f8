// The needle guide: a rail on the ultrasound probe that holds the needle on one line in the image plane.
// Across the line it is a spring, with a click as the needle snaps in. Along the line there is no force,
// except that a free needle is drawn in at the rail's ends.
#pragma once

#include "base/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

// Guide frame: origin at the rail's opening above the skin, +z along the rail toward the needle's hub.
struct GuideSettings {
    // On the left of the probe face, tilted by 25 degrees: the line meets the beam axis at 54 mm depth.
    Pose probe_from_guide{{-0.21643961393810288, 0.0, 0.97629600711993336, 0.0}, {-0.030, 0.0, -0.010}};
    double length_m = 0.060;
    double stiffness_n_per_m = 1000.0;  // across the line
    // Force on a free needle beside the rail: a spring up to `catch_m` from the line, then falling linearly
    // to zero at `reach_m`. The needle feels a click as it drops in past the maximum.
    double catch_m = 0.0015, reach_m = 0.006;
    // Cosine of the largest angle between needle and rail for snapping in: 20 degrees.
    double catch_cosine = 0.94;
    // Lateral force that pulls the needle out of the rail while its tip is outside the body.
    double release_n = 6.0;
};

struct GuideState {
    bool snapped = false;
    bool free = true;  // argument `free` of the last tick
};

// The needle pose and the force after the rail's constraint.
struct GuideResult {
    Pose patient_from_needle;  // on the rail's line while snapped in, else the stylus pose
    Vec3 force_n{0.0};         // on the hand
    // Potential energy of the rail's spring: 0 out of its reach, negative near the line
    double energy_j = 0.0;
    bool event = false;  // snapped in or out, or a free needle within reach entered or left the body
};

// Haptics thread. noexcept, no allocation. One tick of a needle with stylus pose `patient_from_stylus`.
// `free`: the needle is outside the body. Only a free needle snaps in or is pulled out sideways. A needle
// withdrawn through the rail's upper end leaves the rail.
GuideResult stepGuide(GuideState&, const GuideSettings&, const Pose& patient_from_guide,
                      const Pose& patient_from_stylus, bool free) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
