// Occupancy of bricks of 8^3 voxels for one look in the deformed patient, and the distance that a ray may
// leap from each brick.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/volume/deform.h"
#include "render/volume/march_shared.h"

namespace stylet::render {

using gpu::kBrickVoxels;

struct BrickGrid {
    Index3 dims{0};
    std::vector<std::uint8_t> occupied;  // x fastest

    BrickGrid() = default;
    explicit BrickGrid(const Index3& voxels);
    std::size_t offset(int x, int y, int z) const {
        return (std::size_t(z) * std::size_t(dims.y) + std::size_t(y)) * std::size_t(dims.x) + std::size_t(x);
    }
};

// Marks the bricks that planes [z0, z1) of RGBA8 texels make visible: those in which a sample, interpolated
// between voxels, can have a non-zero alpha.
void markOccupied(BrickGrid&, const Index3& voxels, int z0, int z1, const std::byte* rgba);

// Occupancy of the bricks in the breathing patient. A brick of the deformed patient is occupied if any
// point in it comes from an occupied brick of the reference. The tables are read only where both occupied
// and empty bricks are within reach.
class BreathingBricks {
  public:
    BreathingBricks() = default;
    explicit BreathingBricks(const BrickGrid& reference);
    // Recomputes the occupancy with tables that move no point farther than `reach_m`. Allocates nothing.
    void update(const Grid&, const DeformTables&, double reach_m, Workers&);
    void resetToReference() { occupancy_ = reference_; }
    const BrickGrid& occupancy() const { return occupancy_; }
    Index3 dims() const { return reference_.dims; }

  private:
    BrickGrid reference_, occupancy_;
    std::vector<std::uint32_t> to_occupied_, to_empty_;  // Chebyshev distances in the reference
};

// Applies a tool's displacement as well. `breathed`: the occupancy with the breath alone. Allocates nothing
// if `displaced` already has the right size.
void displaceOccupancy(const BrickGrid& breathed, const Grid&, const patient::DisplacementTable&,
                       BrickGrid& displaced);

// Chebyshev distance in bricks from each brick to the nearest occupied one (0: it is occupied itself). All
// nearer bricks are empty.
std::vector<std::uint32_t> leapDistances(const BrickGrid&);
void leapDistances(const BrickGrid&,
                   std::vector<std::uint32_t>& distance);  // allocates nothing if it has the right size

}  // namespace stylet::render
