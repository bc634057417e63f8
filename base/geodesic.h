// Flood fills, connected pieces of a label (a duct tree, a portal vein), and distances along paths inside a
// piece.
// Based on Dijkstra, "A note on two problems in connexion with graphs", Numer. Math. 1, 1959, on the 26
// neighbours of a voxel. Exact along an axis, at most 13 % too long between axes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/volume.h"

namespace stylet {

// Steps to the six neighbours across a voxel's faces.
inline constexpr std::array<Index3, 6> kFaceSteps{Index3(1, 0, 0),  Index3(-1, 0, 0), Index3(0, 1, 0),
                                                  Index3(0, -1, 0), Index3(0, 0, 1),  Index3(0, 0, -1)};

// Flood fill through faces. Calls enter(voxel) for the neighbours of the seeds and of every voxel for which
// enter() has returned true. enter() must mark the voxels that it accepts and refuse marked ones.
template <typename Enter>
void floodFaces(const Grid& grid, std::vector<Index3> seeds, const Enter& enter) {
    while (!seeds.empty()) {
        const Index3 at = seeds.back();
        seeds.pop_back();
        for (const Index3& step : kFaceSteps)
            if (const Index3 next = at + step; grid.contains(next) && enter(next)) seeds.push_back(next);
    }
}

// Returns all offsets with `in(offset)` that are 26-connected to `seed`, in flood-fill order beginning with
// `seed`. Skips offsets that are marked in `seen` and marks the ones it returns.
template <typename In>
std::vector<std::size_t> connectedVoxels(const Grid& grid, std::size_t seed, const In& in,
                                         std::vector<bool>& seen) {
    std::vector<std::size_t> found{seed};
    seen[seed] = true;
    for (std::size_t next = 0; next < found.size(); ++next) {
        const Index3 i = grid.voxelAt(found[next]);
        forEachVoxel(glm::max(i - 1, Index3(0)), glm::min(i + 1, grid.dims - 1), [&](const Index3& other) {
            const std::size_t offset = grid.offset(other);
            if (seen[offset] || !in(offset)) return;
            seen[offset] = true;
            found.push_back(offset);
        });
    }
    return found;
}

using LabelSet = std::array<bool, 256>;
// The 26-connected components of equal label, for all labels of a set, ordered by their first voxels. Each
// is a list of offsets in flood-fill order, beginning with the first voxel.
std::vector<std::vector<std::size_t>> connectedComponents(const LabelVolume&, const LabelSet&);

// One of the 26 steps to a neighbouring voxel.
struct Neighbour {
    std::ptrdiff_t offset = 0;  // offset in the box
    Vec3 step_m{0.0};
    double length_m = 0.0;
};
std::vector<Neighbour> neighbours(const Grid& box);

// A set of voxels, called its members. They are connected, unless makePiece() was called with voxels that are
// not. Members are numbered by ascending offset in the patient's grid, so iterating over them gives the same
// order on every machine.
struct VoxelPiece {
    // part of the patient's grid: the piece and a margin of one voxel around it
    Grid box;
    Index3 low{0};                       // first voxel of the box in the patient's grid; may be -1
    std::vector<std::uint32_t> offsets;  // of the members in the box, ascending
    Volume<std::int32_t> member;         // member number of each voxel of the box, or kNone

    static constexpr std::int32_t kNone = -1;
    std::size_t size() const noexcept { return offsets.size(); }
    Index3 voxel(std::size_t m) const noexcept {
        return box.voxelAt(offsets[m]) + low;
    }  // in the patient's grid
    Vec3 centre(std::size_t m) const noexcept { return box.centre(box.voxelAt(offsets[m])); }  // metres
    std::int32_t at(const Index3& voxel) const noexcept {
        const Index3 i = voxel - low;
        return box.contains(i) ? this->member[i] : kNone;
    }
    std::int32_t neighbour(std::size_t m, const Neighbour& n) const noexcept {
        return this->member.voxels[std::size_t(std::ptrdiff_t(offsets[m]) + n.offset)];
    }
};

// The piece that consists of these voxels of a grid. They need not be connected.
VoxelPiece makePiece(const Grid&, std::vector<std::size_t> offsets);
// 26-connected voxels around `seed` with its label. Empty if `seed` is outside the grid.
VoxelPiece connectedPiece(const LabelVolume&, const Index3& seed);
// The same, but with all labels of a set.
VoxelPiece connectedPiece(const LabelVolume&, const Index3& seed, const LabelSet&);
// connectedComponents() as pieces.
std::vector<VoxelPiece> connectedPieces(const LabelVolume&, const LabelSet&);

inline constexpr double kUnreached_m = std::numeric_limits<double>::infinity();

// A start member and its initial distance.
struct PathStart {
    std::size_t member = 0;
    double at_m = 0.0;
};
// Distance [m] of every member from the nearest start. kUnreached_m if no path leads there or if the shortest
// path is longer than `limit_m`. `cost(from, to, step)` replaces the length of a step; return infinity to
// forbid the step.
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
