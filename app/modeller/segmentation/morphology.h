// Mask operations for the build stages: morphology with balls, components, region growing. Outside the
// grid, masks continue as at the border: a mask cut by the section is not eroded there.
#pragma once

#include <cstdint>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

Mask both(Mask, const Mask&);     // intersection
Mask without(Mask, const Mask&);  // in the first but not in the second
Mask either(Mask, const Mask&);   // union
std::size_t countOf(const Mask&);
double voxelVolume_ml(const Grid&);
double volume_ml(const Mask&);

// The bounding box of a mask, both ends inclusive; `low` is above `high` if the mask is empty.
struct VoxelBox {
    Index3 low{0}, high{-1};
    bool empty() const { return low.x > high.x; }
};
VoxelBox boxOf(const Mask&);
// The part of the mask inside the box, on its own grid.
Mask cropped(const Mask&, const VoxelBox&);

// Morphology with a ball: voxels whose centres are within the radius of a voxel's centre. A radius below
// the spacing changes nothing.
Mask dilated(const Mask&, double radius_m);
Mask eroded(const Mask&, double radius_m);
Mask opened(const Mask&, double radius_m);
Mask closed(const Mask&, double radius_m);

// Connected components by face neighbours, or by all 26. Numbered from 1 in the order of their first
// voxels.
struct Pieces {
    Volume<std::int32_t> number;    // 0 outside the mask
    std::vector<std::size_t> size;  // in voxels; size[0] is 0
    int count() const { return int(size.size()) - 1; }
    int largest() const;  // 0 if there is none
};
enum class Touch { faces, corners };
Pieces piecesOf(const Mask&, Touch = Touch::faces);
Mask pieceOf(const Pieces&, int number);
// Drops pieces smaller than `least_ml`.
void dropSmall(Mask&, double least_ml, Touch = Touch::faces);
// Keeps the pieces that contain a voxel of `seeds`.
Mask piecesWith(const Mask&, const Mask& seeds);

// Fills pockets that are not connected to the grid's border across faces.
void fillCavities(Mask&);

// Assigns each passable voxel the number of the seed that reaches it in the fewest steps across faces,
// within `most_steps`. Of equally near seeds, the first in voxel order wins. Seeds keep their number.
LabelVolume growSeeds(const LabelVolume& seeds, const Mask& passable, int most_steps = 1 << 20);

}  // namespace stylet::modeller
