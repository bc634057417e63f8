// The needle guide: a rail on the ultrasound probe that keeps the needle on one line of its picture.
// Across the line it is a spring that gives a click as the needle snaps in; along it nothing is felt, save
// where it draws a free needle in at its ends.
#pragma once

#include "haptics/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

using patient::Pose;
using patient::Vec3;

// Guide frame: origin at the rail's mouth over the skin, +z along the rail toward the needle's hub.
struct GuideSettings {
    // On the left of the probe's face, tilted by 25 degrees: the line meets the beam's axis 54 mm deep.
    Pose probe_from_guide{{-0.21643961393810288, 0.0, 0.97629600711993336, 0.0}, {-0.030, 0.0, -0.010}};
    double length_m = 0.060;
    double stiffness_n_per_m = 1000.0;  // across the line
    // What a free needle feels of the rail: the spring up to `catch_m` beside the line, then less and less
    // up to `reach_m`. Carried over that crest it drops in: the click.
    double catch_m = 0.0015, reach_m = 0.006;
    double catch_cosine =
        0.94;                // of the angle between needle and rail at which it still snaps in: 20 degrees
    double release_n = 6.0;  // what tears the needle out again while its tip is outside the body
};

struct GuideState {
    bool snapped = false;
    bool free = true;  // as told in the last tick
};

// What the rail makes of a hand.
struct Guided {
    Pose patient_from_needle;  // on the line while snapped, else the hand's own
    Vec3 force_n{0.0};         // on the hand
    double energy_j = 0.0;     // in the rail's spring; 0 out of its reach, less within
    bool event = false;        // snapped in or out, or a needle felt beside it went in or came out
};

// Haptics thread. noexcept, no allocation. One tick of a needle held as `patient_from_stylus`. Only a needle
// outside the body (`free`) snaps in or is torn out; one drawn out through the rail's upper end leaves it.
Guided stepGuide(GuideState&, const GuideSettings&, const Pose& patient_from_guide,
                 const Pose& patient_from_stylus, bool free) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
