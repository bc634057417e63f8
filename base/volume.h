// A dense voxel volume: values on a Grid, x-fastest.
#pragma once

#include <cstdint>
#include <vector>

#include "base/geometry.h"

namespace stylet {

// Largest volume that is read from a file.
inline constexpr int kMaxVoxelsPerSide = 1024;
inline constexpr std::size_t kMaxVoxels = std::size_t(512) << 20;

template <typename T>
struct Volume {
    Grid grid;
    std::vector<T> voxels;

    Volume() = default;
    explicit Volume(const Grid& g, T fill = T{}) : grid(g), voxels(g.voxelCount(), fill) {}

    T& operator[](const Index3& i) noexcept { return voxels[grid.offset(i)]; }
    const T& operator[](const Index3& i) const noexcept { return voxels[grid.offset(i)]; }
    // Value of the nearest voxel, or `outside` beyond the grid.
    T nearestOr(const Vec3& p, T outside) const noexcept {
        const Index3 i = grid.nearest(p);
        return grid.contains(i) ? (*this)[i] : outside;
    }
};

using CtVolume = Volume<std::int16_t>;     // HU
using LabelVolume = Volume<std::uint8_t>;  // ids of Package::labels, 0 = unsegmented

}  // namespace stylet
