// Which bricks of 8^3 voxels a look leaves empty, in the patient as he is now, and how far one may leap from
// each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/deform.h"

namespace stylet::render {

inline constexpr int kBrickVoxels = 8;

struct BrickGrid {
    patient::Index3 dims{0};
    std::vector<std::uint8_t> occupied;  // x fastest

    BrickGrid() = default;
    explicit BrickGrid(const patient::Index3& voxels);
    std::size_t offset(int x, int y, int z) const {
        return (std::size_t(z) * std::size_t(dims.y) + std::size_t(y)) * std::size_t(dims.x) + std::size_t(x);
    }
};

// Marks the bricks that planes [z0, z1) of RGBA8 texels make visible: those whose samples, interpolated
// between voxels, can meet a non-zero alpha.
void markOccupied(BrickGrid&, const patient::Index3& voxels, int z0, int z1, const std::byte* rgba);

// The same seen through the breath: a brick of the deformed patient is occupied when any point in it comes
// from an occupied brick of the reference.
BrickGrid deformOccupancy(const BrickGrid& reference, const patient::Grid&, const DeformTables&);

// Chebyshev distance in bricks to the nearest occupied brick: 0 = occupied. All bricks nearer than it are
// empty.
std::vector<std::uint32_t> leapDistances(const BrickGrid&);

}  // namespace stylet::render
