// Thresholds for a partly segmented patient, from the statistics of its own CT.
#pragma once

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::modeller {

// Classes: fat and soft tissue (peaks of the unsegmented body), bone and vessels (their labels), as normal
// distributions. t2_sensitive is where soft tissue and bone are equally likely, but clear of soft tissue's
// noise; t2_specific = max(t2_sensitive, vessels' mean + 4 sigma).
patient::Thresholds thresholdsOf(const patient::CtVolume&, const patient::LabelVolume&, const Mask& body);

}  // namespace stylet::modeller
