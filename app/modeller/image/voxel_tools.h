// Loops over voxels, and basic operations on masks: boxes, distance, components, filling, smoothing. A mask
// is a LabelVolume of 0 and 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <vector>

#include "base/geodesic.h"
#include "base/parallel.h"
#include "base/statistics.h"
#include "base/volume.h"

namespace stylet::modeller {

using Mask = LabelVolume;
using FloatVolume = Volume<float>;

// A box of voxels, both ends inclusive; `low` is above `high` if it is empty.
struct VoxelBox {
    Index3 low{0}, high{-1};
    bool empty() const { return low.x > high.x; }
};

// Visits the voxels of a box in memory order.
template <typename Visit>
void forEachVoxel(const VoxelBox& box, const Visit& visit) {
    stylet::forEachVoxel(box.low, box.high, visit);
}

// The voxels at most `reach` steps away along each axis, within the grid.
inline VoxelBox boxAround(const Grid& grid, const Index3& at, int reach) {
    return {glm::max(at - reach, Index3(0)), glm::min(at + reach, grid.dims - 1)};
}

// The neighbours of a voxel: the six that share a face with it, or all 26.
enum class Connectivity { faces, corners };

// Calls visit(offset) for every neighbour inside the grid.
template <typename Visit>
void forEachNeighbour(const Grid& grid, const Index3& at, Connectivity touch, const Visit& visit) {
    if (touch == Connectivity::faces) {
        for (const Index3& step : kFaceSteps)
            if (grid.contains(at + step)) visit(grid.offset(at + step));
        return;
    }
    forEachVoxel(boxAround(grid, at, 1), [&](const Index3& i) {
        if (i != at) visit(grid.offset(i));
    });
}

// base/parallel.h's parallelVoxels() with one thread per processor.
template <typename Visit>
void parallelVoxels(const Grid& grid, const Visit& visit) {
    stylet::parallelVoxels(processorCount(), grid, visit);
}

// Mask of the voxels for which `in` returns true; `in` receives a voxel's offset.
template <typename In>
Mask maskWhere(const Grid& grid, const In& in) {
    Mask mask(grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = in(i);
    return mask;
}

// The first set voxel from `at` on, or `end`.
const std::uint8_t* nextSet(const std::uint8_t* at, const std::uint8_t* end);

// The bounding box of a mask.
VoxelBox boundingBox(const Mask&);
// The same, enlarged by `margin` voxels on every side, within the grid.
VoxelBox boxAround(const Mask&, int margin);
// The part of a volume inside the box, on its own grid.
template <typename T>
Volume<T> cropped(const Volume<T>& whole, const VoxelBox& box) {
    Volume<T> part(Grid{box.high - box.low + 1, whole.grid.spacing_m, whole.grid.centre(box.low)});
    for (int z = 0; z < part.grid.dims.z; ++z)
        for (int y = 0; y < part.grid.dims.y; ++y)
            std::copy_n(&whole[box.low + Index3(0, y, z)], part.grid.dims.x, &part[{0, y, z}]);
    return part;
}
// Copies `part` into the volume, with its first voxel at `low`.
void paste(const Mask& part, const Index3& low, Mask& into);

template <typename T>
FloatVolume toFloat(const Volume<T>& volume) {
    FloatVolume out(volume.grid);
    std::copy(volume.voxels.begin(), volume.voxels.end(), out.voxels.begin());
    return out;
}

// The voxels with this label.
Mask withLabel(const LabelVolume&, std::uint8_t label);

// Sets steps[x] to the number of voxels from x to the nearest set voxel of a row of n. Returns false if the
// row has none; `steps` is then undefined.
bool stepsAlongRow(const std::uint8_t* mask, int n, float* steps);

// Distance in metres from each voxel's centre to the nearest voxel of the mask: 0 inside the mask, 1e3
// everywhere if the mask is empty. Exact; Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled
// Functions", Theory of Computing 8, 2012.
FloatVolume distanceTo(const Mask&);

// Connected components, numbered from 1 in the order of their first voxels.
struct Components {
    Volume<std::int32_t> number;    // 0 outside the mask
    std::vector<std::size_t> size;  // in voxels; size[0] is 0
    int count() const { return int(size.size()) - 1; }
    int largest() const;  // 0 if there is none
};
Components findComponents(const Mask&, Connectivity = Connectivity::faces);
// Whether each of `count` numbers is above 0 and keep(number) is true.
template <typename Keep>
std::vector<std::uint8_t> keptComponents(std::size_t count, const Keep& keep) {
    std::vector<std::uint8_t> kept(count, 0);
    for (std::size_t n = 1; n < count; ++n)
        kept[n] = keep(n);
    return kept;
}
// The components for which keep(number) is true.
template <typename Keep>
Mask componentsWhere(const Components& components, const Keep& keep) {
    const std::vector<std::uint8_t> kept = keptComponents(components.size.size(), keep);
    const auto& number = components.number;
    return maskWhere(number.grid, [&](std::size_t i) { return kept[std::size_t(number.voxels[i])]; });
}

// Keeps the largest 6-connected component; returns the number of voxels that were dropped.
std::size_t keepLargestComponent(Mask&);

// The voxels of `passable` that are 6-connected to a voxel of `seeds`.
Mask floodFill(const Mask& seeds, const Mask& passable);

// Keeps the pieces that lie inside an organ which the ribs enclose, and drops the ribs themselves. A plane
// separates a rib from that organ, so at most three of the six axis directions lead from the rib to it. A
// piece is kept if at least four directions do so from nine tenths of its voxels.
Mask surroundedPieces(const Mask& pieces, const Mask& organ);

// Fills all holes of the mask in each axial slice.
void fillHolesPerSlice(Mask&);

// Mean over a cube of 2 * reach + 1 voxels per side, clipped at the grid's border.
FloatVolume boxMean(const FloatVolume&, int reach);

// The complement of the mask.
Mask inverted(Mask);

inline double voxelVolume_ml(const Grid& g) {
    return g.spacing_m.x * g.spacing_m.y * g.spacing_m.z * 1e6;
}

// Measures the noise in an organ: the standard deviation between its voxels 4 mm, but at least two voxels,
// apart along x. NaN if there are none. The median of absolute differences is robust against vessels and
// lesions.
template <typename T>
double measureNoise_hu(const Volume<T>& hu, const Mask& organ) {
    constexpr double kLag_m = 0.004;
    const Grid& g = hu.grid;
    const int lag = std::max(2, int(std::lround(kLag_m / g.spacing_m.x)));
    std::vector<double> differences;
    forEachVoxel(g, [&](const Index3& i) {
        if (i.x + lag < g.dims.x && organ[i] && organ[i + Index3{lag, 0, 0}])
            differences.push_back(std::abs(double(hu[i]) - double(hu[i + Index3{lag, 0, 0}])));
    });
    if (differences.empty()) return std::nan("");
    return upperMedian(std::move(differences)) / (0.6745 * std::sqrt(2.0));
}

}  // namespace stylet::modeller
