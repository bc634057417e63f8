// Thresholds for a partly segmented patient, from the statistics of its own CT.
#pragma once

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::app {

// Classes: air, fat and soft tissue (peaks of the unsegmented body), bone and vessels (their labels). Borders
// are where neighbouring normal distributions are equally likely; t2_specific = max(t2_sensitive, vessels'
// mean + 4 sigma).
patient::Thresholds thresholdsOf(const patient::CtVolume&, const patient::LabelVolume&, const Mask& body);

}  // namespace stylet::app
