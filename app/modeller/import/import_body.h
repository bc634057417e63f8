// Separates the body from air and table, and makes the skin as a shell of the body.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Everything inside the body's outline, including lungs and bowel gas. Takes voxels of fat density or more,
// removes thin objects (table, blanket) by opening, keeps the largest component, and fills holes in each
// axial slice.
Mask bodyMask(const CtVolume&);

// The outermost `thickness_m` of the body, 6-separating at air inside the scan. No skin where the scan cuts
// the body (`scanned` is the CT's own grid).
Mask skinShell(const Mask& body, const Grid& scanned, double thickness_m);

}  // namespace stylet::modeller
