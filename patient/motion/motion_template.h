// A motion for a patient with a single CT: typical amplitudes, fitted to the labels.
// Amplitudes at rest after Keall et al. 2006 (AAPM TG 76) and Clifford et al. 2002: diaphragm and liver
// 10-25 mm cranio-caudal, 5 antero-posterior, 2-3 lateral. Ribs move in a bucket-handle motion; the
// abdominal wall rises.
#pragma once

#include <vector>

#include "patient/motion/motion.h"
#include "patient/tissue/tissue.h"

namespace stylet::patient {

// Displacements from end-exhale to end-inhale [m].
struct MotionAmplitudes {
    double dome_m = 0.015;          // diaphragm, liver and organs below: toward the feet
    double anterior_m = 0.005;      // the same, to the front
    double lateral_m = 0.0025;      // the same, to the left
    double rib_m = 0.002;           // ribs of the flank: outward, and two thirds of it toward the head
    double belly_m = 0.005;         // abdominal wall below the ribs: to the front
    double hysteresis_m_s = 0.001;  // lag of the dome behind v, per unit of v'
    double spacing_m = 0.006;       // node spacing
};

// The cavity is the region inside the fascia that is connected to the liver. If there is no fascia or it
// leaks, the cavity is a rounded hull around the organs. Bones lie outside the cavity; the spine does not
// move. The field covers the range of the liver's motion. It fades to zero above and below, within the image
// if there is room. Without a liver the model has no nodes. The same labels give the same bits for any thread
// count.
MotionModel motionTemplate(const LabelVolume&, const std::vector<Label>&, const MotionAmplitudes&,
                           const Surrogate& reference, int threads = 2);

}  // namespace stylet::patient
