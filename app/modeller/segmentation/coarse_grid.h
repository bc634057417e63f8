// Resamples volumes to a coarser grid over the same region.
#pragma once

#include <functional>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Returns a grid with cubic voxels of side `spacing_m` and the same centre. It covers the given grid to
// within half a voxel.
Grid coarseGrid(const Grid&, double spacing_m);

// The mean of value(offset) over the fine voxels in each coarse voxel, or the nearest fine voxel's value if
// a coarse voxel contains none.
FloatVolume coarseMean(const Grid& coarse, const Grid& fine, const std::function<float(std::size_t)>& value);

}  // namespace stylet::modeller
