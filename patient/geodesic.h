// Pieces of a patient that hang together (a duct tree, a portal vein), and the way inside them.
// Based on Dijkstra, "A note on two problems in connexion with graphs", Numer. Math. 1, 1959, on the 26
// neighbours of a voxel: along an axis exact, at worst 13 % too long between the axes.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "patient/volume.h"

namespace stylet::patient {

// One of the 26 steps to a voxel beside another.
struct Neighbour {
    std::ptrdiff_t offset = 0;  // in the box
    Vec3 step_m{0.0};
    double length_m = 0.0;
};
std::vector<Neighbour> neighbours(const Grid& box);

// Members are numbered in the order of their offsets in the patient's grid, so whatever goes through them in
// that order is the same on every machine.
struct VoxelPiece {
    Grid box;                            // part of the patient's grid, a margin of one voxel around the piece
    Index3 low{0};                       // the box's first voxel in the patient's grid; may be -1
    std::vector<std::uint32_t> offsets;  // of the members, in the box, ascending
    Volume<std::int32_t> member;         // number of a voxel of the box, kNone where it is none

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

// 26-connected voxels of equal label around `seed`; none beyond the grid.
VoxelPiece pieceAround(const LabelVolume&, const Index3& seed);
// The same with all labels of a set.
using LabelSet = std::array<bool, 256>;
VoxelPiece pieceAround(const LabelVolume&, const Index3& seed, const LabelSet&);
// All pieces of equal label, ordered by their first voxels.
std::vector<VoxelPiece> piecesOf(const LabelVolume&, const LabelSet&);

inline constexpr double kUnreached_m = std::numeric_limits<double>::infinity();

// A place to start from, and how far that already is.
struct WayStart {
    std::size_t member = 0;
    double at_m = 0.0;
};
// Metres from the starts to every member, kUnreached_m where no way leads or it is longer than `limit_m`.
// `cost(from, to, step)` in place of a step's length, infinite where it must not be taken.
using StepCost = std::function<double(std::size_t from, std::size_t to, const Neighbour&)>;
std::vector<double> geodesic_m(const VoxelPiece&, std::span<const WayStart>, const StepCost& cost = {},
                               double limit_m = kUnreached_m);

// Distance in metres from each member's centre to the piece's wall: to the nearest voxel that is none, less
// half a voxel.
std::vector<double> wallDistance_m(const VoxelPiece&);

// Radius of the widest ball inside the piece that covers a member (Hildebrand and Ruegsegger 1997): of a
// vessel, its lumen's.
std::vector<double> lumenRadius_m(const VoxelPiece&, std::span<const double> wall_m);

}  // namespace stylet::patient
