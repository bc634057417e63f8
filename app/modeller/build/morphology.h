// What the stages need beyond voxel_tools.h: morphology with balls, components, growth by steps. Beyond the
// grid everything goes on as at its border: a mask cut by the section is not eroded from there.
#pragma once

#include <cstdint>
#include <vector>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

Mask both(Mask, const Mask&);     // in each of the two
Mask without(Mask, const Mask&);  // in the first only
Mask either(Mask, const Mask&);   // in one of the two
std::size_t countOf(const Mask&);
double voxelVolume_ml(const patient::Grid&);
double volume_ml(const Mask&);

// The smallest box of voxels that holds a mask, both ends included; `low` above `high` where it is empty.
struct VoxelBox {
    patient::Index3 low{0}, high{-1};
    bool empty() const { return low.x > high.x; }
};
VoxelBox boxOf(const Mask&);
// What of the mask lies in the box, on a grid of its own.
Mask cropped(const Mask&, const VoxelBox&);

// With a ball of radius r: voxels whose centres lie within it of a voxel's centre. A radius below the spacing
// changes nothing.
Mask dilated(const Mask&, double radius_m);
Mask eroded(const Mask&, double radius_m);
Mask opened(const Mask&, double radius_m);
Mask closed(const Mask&, double radius_m);

// Pieces by face neighbours, or by all 26; numbered from 1 in the order of their first voxels.
struct Pieces {
    patient::Volume<std::int32_t> number;  // 0 outside the mask
    std::vector<std::size_t> size;         // voxels; size[0] is 0
    int count() const { return int(size.size()) - 1; }
    int largest() const;  // 0 where there is none
};
enum class Touch { faces, corners };
Pieces piecesOf(const Mask&, Touch = Touch::faces);
Mask pieceOf(const Pieces&, int number);
// Drops pieces smaller than this.
void dropSmall(Mask&, double least_ml, Touch = Touch::faces);
// Keeps the pieces that hold a voxel of `seeds`.
Mask piecesWith(const Mask&, const Mask& seeds);

// Pockets that no way of faces joins to the grid's border.
void fillCavities(Mask&);

// Each passable voxel gets the number of the seed that reaches it in the fewest steps over faces, within
// `most_steps`; of equally near ones the first in voxel order. Seeds keep their own.
patient::LabelVolume growSeeds(const patient::LabelVolume& seeds, const Mask& passable,
                               int most_steps = 1 << 20);

}  // namespace stylet::modeller
