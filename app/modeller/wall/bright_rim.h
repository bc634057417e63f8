// Soft tissue that blur makes as bright as bone.
#pragma once

#include "app/modeller/image/scan_blur.h"

namespace stylet::modeller {

// Distance to which blur makes the tissue beside bone brighter.
double blurReach(const Grid&, const ScanBlur&);
// Soft tissue next to a bone that is above `bone_hu` because of blur. Without a label it would stop a needle.
// Voxels surrounded by bright voxels are excluded, because they are missed bone.
Mask brightRim(const CtVolume&, const Mask& body, const Mask& bones, double bone_hu, const ScanBlur&);

}  // namespace stylet::modeller
