// What can be wrong with the frame of a finished image: cut field of view, and a header that does not
// describe the image.
#pragma once

#include "patient/patient.h"

namespace stylet::patient::synth {

// Cuts off the image inside the body, this far from the body's border: right flank, or from above or below
// the liver's border.
void cutRight(Package&, double depth_m);
void cutTop(Package&, double depth_m);
void cutBottom(Package&, double depth_m);

// Reverses the voxels along these axes. The grid stays, so the header is wrong afterwards. Removes the
// motion, which belongs to the true orientation.
void reverse(Package&, bool x, bool y, bool z);

// Multiplies the stated slice distance. Removes the motion.
void misstateSpacing(Package&, double factor);

// Adds a constant to every CT value, as if the rescale intercept were ignored.
void shiftHu(Package&, int hu);

}  // namespace stylet::patient::synth
