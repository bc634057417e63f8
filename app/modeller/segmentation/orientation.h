// Refuses scans whose file gives wrong axes, before anything is searched for in the wrong place. All masks
// of a call are on one grid. alignAtlases() finds exchanged sides.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Throws ImportError if the lungs lie below the middle of the body. Without lungs, nothing can be said.
void checkUpright(const Mask& body, const Mask& lungs);

// Throws ImportError if the bones lie in front of the middle of the body. Without bones, nothing can be said.
void checkFrontAndBack(const Mask& body, const Mask& bones);

}  // namespace stylet::modeller
