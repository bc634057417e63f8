// Exact Euclidean distances on a voxel grid.
// Based on Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8,
// 2012.
#pragma once

#include "patient/volume.h"

namespace stylet::patient {

enum class Sites {
    all,
    above  // only sites at the same height or further toward the head count
};

// Distance in metres from every voxel's centre to the nearest centre of a non-zero voxel of `mask`; infinite
// where there is none. The thread count does not change the result.
Volume<float> distanceTo(const Volume<std::uint8_t>& mask, Sites, int threads);

// Linear between voxel centres, constant beyond the grid.
double linearAt(const Volume<float>&, const Vec3& p) noexcept;

}  // namespace stylet::patient
