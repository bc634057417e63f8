// Basic operations on masks: distance, components, filling, smoothing. A mask is a LabelVolume of 0 and 1.
#pragma once

#include <functional>

#include "base/volume.h"

namespace stylet::modeller {

using Mask = LabelVolume;
using FloatVolume = Volume<float>;

// Runs f(0) ... f(count - 1) on two threads; the result must not depend on the order.
void forEachSlab(int count, const std::function<void(int)>& f);

// Distance in metres from each voxel's centre to the nearest voxel of the mask (0 inside it, 1e3 if it is
// empty). Exact; Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of
// Computing 8, 2012.
FloatVolume distanceTo(const Mask&);

// Keeps the largest 6-connected component; returns the number of voxels that were dropped.
std::size_t keepLargest(Mask&);

// The voxels of `passable` that are 6-connected to a voxel of `seeds`.
Mask floodFrom(const Mask& seeds, const Mask& passable);

// Fills all holes of the mask in each axial slice.
void fillHolesPerSlice(Mask&);

// Mean over a cube of 2 * reach + 1 voxels per side, clipped at the grid's border.
FloatVolume boxMean(const FloatVolume&, int reach);

// The complement of the mask.
Mask inverted(Mask);

}  // namespace stylet::modeller
