// Exact Euclidean distances on a voxel grid.
// Based on Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8,
// 2012.
#pragma once

#include "base/volume.h"

namespace stylet {

enum class Sites {
    all,
    above  // only sites at the same height or closer to the head count
};

// Distance [m] from every voxel's centre to the nearest centre of a non-zero voxel of `mask`; infinite if
// there is none. The result does not depend on the thread count.
Volume<float> distanceTo(const Volume<std::uint8_t>& mask, Sites, int threads);

// Trilinear between voxel centres, constant outside the grid.
double sampleTrilinear(const Volume<float>&, const Vec3& p) noexcept;

}  // namespace stylet
