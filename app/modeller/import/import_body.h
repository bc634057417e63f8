// Separates the body from air and table, and makes the skin as a shell of the body.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Everything inside the body's outline, including lungs and bowel gas. Takes voxels of fat density or more,
// removes thin objects (table, blanket) by opening, keeps the largest component, and fills holes in each
// axial slice.
Mask bodyMask(const CtVolume&);

// Returns the skin: the layer of the body within `thickness_m` of the air. No path over face neighbours
// passes through the layer (6-separating). `scanned` is the grid of the original CT. Where its border cuts
// the body, there is no skin.
Mask skinShell(const Mask& body, const Grid& scanned, double thickness_m);

}  // namespace stylet::modeller
