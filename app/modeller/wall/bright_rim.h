// Soft tissue that blur makes as bright as bone.
#pragma once

#include "app/modeller/image/scan_blur.h"

namespace stylet::modeller {

// Distance to which blur makes the tissue beside bone brighter.
double blurReach(const Grid&, const ScanBlur&);
// Soft tissue beside bone that blur raises above `bone_hu`. Unlabelled, it would count as bone and stop a
// needle. Leaves out voxels surrounded by bright voxels: they are missed bone.
Mask brightRim(const CtVolume&, const Mask& body, const Mask& bones, double bone_hu, const ScanBlur&);

}  // namespace stylet::modeller
