// Finds the voxels outside a closed border.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::test {

// Flood-fills over voxel faces from the left and right rear edges of the image. Voxels with the label
// `border` stop the fill. Returns the voxels reached.
inline modeller::Mask outsideOf(const LabelVolume& labels, std::uint8_t border) {
    modeller::Mask seeds(labels.grid);
    for (int z = 0; z < seeds.grid.dims.z; ++z)
        seeds[{0, 0, z}] = seeds[{seeds.grid.dims.x - 1, 0, z}] = 1;
    return modeller::floodFill(
        seeds, modeller::maskWhere(labels.grid, [&](std::size_t i) { return labels.voxels[i] != border; }));
}

}  // namespace stylet::test
