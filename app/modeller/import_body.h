// The body against the air and the table, and the skin as a shell of it.
#pragma once

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// Everything inside the body's outline, lungs and gut gas included: fat or denser, largest component after
// thin things (table, blanket) are opened away, holes filled in each axial slice.
Mask bodyMask(const patient::CtVolume&);

// The outermost `thickness_m` of the body, 6-separating where it meets air that the scanner saw; none where
// the scan cuts the body (`scanned` is the CT's own grid).
Mask skinShell(const Mask& body, const patient::Grid& scanned, double thickness_m);

}  // namespace stylet::modeller
