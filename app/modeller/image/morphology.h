// Mask operations for the build stages: sets, morphology with balls, region growing. Outside the grid, the
// voxels at the border are assumed to continue, so a mask cut by the section is not eroded there.
#pragma once

#include <cstdint>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

Mask intersect(Mask, const Mask&);  // intersection
Mask subtract(Mask, const Mask&);   // in the first but not in the second
Mask unite(Mask, const Mask&);      // union
std::size_t countVoxels(const Mask&);
double volume_ml(const Mask&);

// Morphology with a ball: voxels whose centres are within the radius of a voxel's centre. A radius below
// the spacing changes nothing.
Mask dilated(const Mask&, double radius_m);
Mask eroded(const Mask&, double radius_m);
Mask opened(const Mask&, double radius_m);
Mask closed(const Mask&, double radius_m);

Mask componentMask(const Components&, int number);
// Drops pieces smaller than `min_ml`.
void removeSmallComponents(Mask&, double min_ml, Connectivity = Connectivity::faces);

// Fills pockets that are not connected to the grid's border across faces.
void fillCavities(Mask&);

// Assigns each passable voxel the number of the seed that reaches it in the fewest steps across faces,
// within `max_steps`. Of equally near seeds, the first in voxel order wins. Seeds keep their number.
LabelVolume growSeeds(const LabelVolume& seeds, const Mask& passable, int max_steps = 1 << 20);

}  // namespace stylet::modeller
