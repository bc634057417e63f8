// Connected pieces of a label (a duct tree, a portal vein) and distances along paths inside them.
// Based on Dijkstra, "A note on two problems in connexion with graphs", Numer. Math. 1, 1959, on the 26
// neighbours of a voxel. Exact along an axis, at most 13 % too long between axes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/volume.h"

namespace stylet {

// All offsets with `in(offset)` that are 26-connected to `seed`, beginning with `seed`, in flood-fill order.
// Skips offsets that are marked in `seen` and marks the ones it returns.
template <typename In>
std::vector<std::size_t> connectedVoxels(const Grid& grid, std::size_t seed, const In& in,
                                         std::vector<bool>& seen) {
    std::vector<std::size_t> found{seed};
    seen[seed] = true;
    for (std::size_t next = 0; next < found.size(); ++next) {
        const Index3 i = grid.voxelAt(found[next]);
        for (int z = std::max(i.z - 1, 0); z <= std::min(i.z + 1, grid.dims.z - 1); ++z)
            for (int y = std::max(i.y - 1, 0); y <= std::min(i.y + 1, grid.dims.y - 1); ++y)
                for (int x = std::max(i.x - 1, 0); x <= std::min(i.x + 1, grid.dims.x - 1); ++x) {
                    const std::size_t offset = grid.offset({x, y, z});
                    if (seen[offset] || !in(offset)) continue;
                    seen[offset] = true;
                    found.push_back(offset);
                }
    }
    return found;
}

// One of the 26 steps to a neighbouring voxel.
struct Neighbour {
    std::ptrdiff_t offset = 0;  // offset in the box
    Vec3 step_m{0.0};
    double length_m = 0.0;
};
std::vector<Neighbour> neighbours(const Grid& box);

// A connected set of voxels, its members. Members are numbered by ascending offset in the patient's grid,
// so iterating over them gives the same order on every machine.
struct VoxelPiece {
    // part of the patient's grid, with a margin of one voxel around the piece
    Grid box;
    Index3 low{0};                       // first voxel of the box in the patient's grid; may be -1
    std::vector<std::uint32_t> offsets;  // of the members in the box, ascending
    Volume<std::int32_t> member;         // member number of each voxel of the box, or kNone

    static constexpr std::int32_t kNone = -1;
    std::size_t size() const noexcept { return offsets.size(); }
    Index3 voxel(std::size_t m) const noexcept;  // in the patient's grid
    Vec3 centre(std::size_t m) const noexcept;   // metres
    std::int32_t at(const Index3& voxel) const noexcept {
        const Index3 i = voxel - low;
        return box.contains(i) ? this->member[i] : kNone;
    }
    std::int32_t beside(std::size_t m, const Neighbour& n) const noexcept {
        return this->member.voxels[std::size_t(std::ptrdiff_t(offsets[m]) + n.offset)];
    }
};

// 26-connected voxels around `seed` with its label. Empty if `seed` is outside the grid.
VoxelPiece pieceAround(const LabelVolume&, const Index3& seed);
// The same, connected through all labels of a set.
using LabelSet = std::array<bool, 256>;
VoxelPiece pieceAround(const LabelVolume&, const Index3& seed, const LabelSet&);
// All connected pieces of equal label, ordered by their first voxels.
std::vector<VoxelPiece> piecesOf(const LabelVolume&, const LabelSet&);

inline constexpr double kUnreached_m = std::numeric_limits<double>::infinity();

// A start member and its initial distance.
struct PathStart {
    std::size_t member = 0;
    double at_m = 0.0;
};
// Distance [m] of every member from the nearest start; kUnreached_m if no path leads there or it is longer
// than `limit_m`. `cost(from, to, step)` replaces the length of a step; return infinity to forbid the
// step.
using StepCost = std::function<double(std::size_t from, std::size_t to, const Neighbour&)>;
std::vector<double> geodesic_m(const VoxelPiece&, std::span<const PathStart>, const StepCost& cost = {},
                               double limit_m = kUnreached_m);

// Distance [m] from each member's centre to the wall of the piece: distance to the nearest voxel outside
// the piece, minus half a voxel.
std::vector<double> wallDistance_m(const VoxelPiece&);

// Radius of the largest ball inside the piece that covers a member (Hildebrand and Ruegsegger 1997). For a
// vessel this is the radius of its lumen.
std::vector<double> lumenRadius_m(const VoxelPiece&, std::span<const double> wall_m);

}  // namespace stylet
