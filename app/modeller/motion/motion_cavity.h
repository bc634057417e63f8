// The sliding interface of a chest: the pleura of a 4D CT, found without labels.
#pragma once

#include "app/modeller/motion/phases.h"

namespace stylet::modeller {

// The volume inside the ribs, on the phases' grid. Next to lung, the wall is at the outermost voxel that is
// air in any phase. Below the lung, the wall is extrapolated inside the ribs. The cavity is open towards the
// mediastinum and the ends of the image, and excludes the vertebrae. Throws ImportError if there is no lung.
Mask chestCavity(const std::vector<Phase>&);

// Signed distance to the mask's surface in metres, negative inside.
FloatVolume signedDistance(const Mask&);

}  // namespace stylet::modeller
