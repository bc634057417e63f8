// Resamples volumes to a coarser grid over the same region.
#pragma once

#include <functional>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Covers the same box with cubes of about `spacing_m`, centred on it.
Grid coarseGrid(const Grid&, double spacing_m);

// The mean of value(offset) over the fine voxels in each coarse voxel, or the nearest fine voxel's value if
// a coarse voxel contains none.
FloatVolume coarseMean(const Grid& coarse, const Grid& fine, const std::function<float(std::size_t)>& value);

}  // namespace stylet::modeller
