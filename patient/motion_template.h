// A motion for a patient of whom there is one CT: a template of amplitudes, fitted to the labels.
// Amplitudes at rest after Keall et al. 2006 (AAPM TG 76) and Clifford et al. 2002: diaphragm and liver 10-25
// mm cranio-caudal, 5 antero-posterior, 2-3 lateral; ribs by their bucket handle; the belly's wall rises.
#pragma once

#include <vector>

#include "patient/motion.h"
#include "patient/tissue.h"

namespace stylet::patient {

// From end-exhale to end-inhale, metres.
struct MotionAmplitudes {
    double dome_m = 0.015;          // diaphragm, liver and what lies below: toward the feet
    double anterior_m = 0.005;      // the same, to the front
    double lateral_m = 0.0025;      // the same, to the left
    double rib_m = 0.002;           // the flank's ribs: outward, and two thirds of it toward the head
    double belly_m = 0.005;         // the wall below the ribs: to the front
    double hysteresis_m_s = 0.001;  // lag of the dome behind v, per unit of v'
    double spacing_m = 0.006;       // of the nodes
};

// The cavity is what the fascia encloses together with the liver; without a fascia, or where it leaks, a
// rounded hull around organs. Bones lie outside it, and the spine does not move at all. The field spans what
// the liver passes and fades above and below, within the image where there is room. Without a liver no nodes.
// Same labels, same bits, whatever the thread count.
MotionModel motionTemplate(const LabelVolume&, const std::vector<Label>&, const MotionAmplitudes&,
                           const Surrogate& reference, int threads = 2);

}  // namespace stylet::patient
