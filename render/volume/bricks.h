// Which bricks of 8^3 voxels a look leaves empty, in the patient as he is now, and how far one may leap from
// each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/volume/deform.h"

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

// The same seen through one breath after the other: a brick of the deformed patient is occupied when any
// point in it comes from an occupied brick of the reference. Where all that is within reach is occupied, or
// nothing is, no table need be asked.
class BreathedBricks {
  public:
    BreathedBricks() = default;
    explicit BreathedBricks(const BrickGrid& reference);
    // Through tables that move no point farther than `reach_m`. Allocates nothing.
    void see(const patient::Grid&, const DeformTables&, double reach_m, Workers&);
    void seeReference() { seen_ = reference_; }
    const BrickGrid& seen() const { return seen_; }
    patient::Index3 dims() const { return reference_.dims; }

  private:
    BrickGrid reference_, seen_;
    std::vector<std::uint32_t> to_occupied_, to_empty_;  // chessboard distances in the reference
};

// And through what a tool displaces: `breathed` is what the breath alone would show.
BrickGrid displaceOccupancy(const BrickGrid& breathed, const patient::Grid&,
                            const patient::DisplacementTable&);
// No allocation into a grid that fits.
void displaceOccupancy(const BrickGrid& breathed, const patient::Grid&, const patient::DisplacementTable&,
                       BrickGrid& displaced);

// Chebyshev distance in bricks to the nearest occupied brick: 0 = occupied. All bricks nearer than it are
// empty.
std::vector<std::uint32_t> leapDistances(const BrickGrid&);
void leapDistances(const BrickGrid&,
                   std::vector<std::uint32_t>& distance);  // no allocation into one that fits

}  // namespace stylet::render
