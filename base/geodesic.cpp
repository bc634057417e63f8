#include "base/geodesic.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <queue>

#include "base/distance.h"

namespace stylet {

VoxelPiece makePiece(const Grid& grid, std::vector<std::size_t> offsets) {
    std::sort(offsets.begin(), offsets.end());
    Index3 low(std::numeric_limits<int>::max()), high(std::numeric_limits<int>::min());
    for (const std::size_t offset : offsets) {
        const Index3 i = grid.voxelAt(offset);
        low = glm::min(low, i), high = glm::max(high, i);
    }
    VoxelPiece piece;
    piece.low = low - 1;
    piece.box = {high - low + 3, grid.spacing_m, grid.centre(piece.low)};
    piece.member = Volume<std::int32_t>(piece.box, VoxelPiece::kNone);
    piece.offsets.reserve(offsets.size());
    for (const std::size_t offset : offsets) {
        const std::size_t in_box = piece.box.offset(grid.voxelAt(offset) - piece.low);
        piece.member.voxels[in_box] = std::int32_t(piece.offsets.size());
        piece.offsets.push_back(std::uint32_t(in_box));
    }
    return piece;
}

VoxelPiece connectedPiece(const LabelVolume& labels, const Index3& seed) {
    if (!labels.grid.contains(seed)) return {};
    LabelSet one{};
    one[labels[seed]] = true;
    return connectedPiece(labels, seed, one);
}

VoxelPiece connectedPiece(const LabelVolume& labels, const Index3& seed, const LabelSet& set) {
    if (!labels.grid.contains(seed) || !set[labels[seed]]) return {};
    std::vector<bool> seen(labels.voxels.size());
    const auto in = [&](std::size_t offset) { return set[labels.voxels[offset]]; };
    return makePiece(labels.grid, connectedVoxels(labels.grid, labels.grid.offset(seed), in, seen));
}

std::vector<std::vector<std::size_t>> connectedComponents(const LabelVolume& labels, const LabelSet& set) {
    std::vector<std::vector<std::size_t>> components;
    std::vector<bool> seen(labels.voxels.size());
    for (std::size_t seed = 0; seed < labels.voxels.size(); ++seed) {
        const std::uint8_t label = labels.voxels[seed];
        if (!set[label] || seen[seed]) continue;
        const auto in = [&](std::size_t offset) { return labels.voxels[offset] == label; };
        components.push_back(connectedVoxels(labels.grid, seed, in, seen));
    }
    return components;
}

std::vector<VoxelPiece> connectedPieces(const LabelVolume& labels, const LabelSet& set) {
    std::vector<VoxelPiece> pieces;
    for (std::vector<std::size_t>& component : connectedComponents(labels, set))
        pieces.push_back(makePiece(labels.grid, std::move(component)));
    return pieces;
}

std::vector<Neighbour> neighbours(const Grid& box) {
    std::vector<Neighbour> list;
    forEachVoxel(Index3(-1), Index3(1), [&](const Index3& i) {
        if (i == Index3(0)) return;
        const Vec3 step = box.spacing_m * Vec3(i);
        const std::ptrdiff_t offset =
            (std::ptrdiff_t(i.z) * box.dims.y + i.y) * std::ptrdiff_t(box.dims.x) + i.x;
        list.push_back({offset, step, std::sqrt(glm::dot(step, step))});
    });
    return list;
}

std::vector<double> geodesic_m(const VoxelPiece& piece, std::span<const PathStart> starts,
                               const StepCost& cost, double limit_m) {
    std::vector<double> distance(piece.size(), kUnreached_m);
    using Reached = std::pair<double, std::size_t>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
    const auto reach = [&](std::size_t member, double at_m) {
        if (!(at_m < distance[member]) || at_m > limit_m) return;
        distance[member] = at_m;
        queue.push({at_m, member});
    };
    for (const PathStart& start : starts)
        reach(start.member, start.at_m);
    const std::vector<Neighbour> around = neighbours(piece.box);
    while (!queue.empty()) {
        const auto [at_m, member] = queue.top();
        queue.pop();
        if (at_m > distance[member]) continue;
        for (const Neighbour& n : around) {
            const std::int32_t next = piece.neighbour(member, n);
            if (next == VoxelPiece::kNone) continue;
            reach(std::size_t(next), at_m + (cost ? cost(member, std::size_t(next), n) : n.length_m));
        }
    }
    return distance;
}

std::vector<double> wallDistance_m(const VoxelPiece& piece) {
    Volume<std::uint8_t> outside(piece.box, 1);
    for (const std::uint32_t offset : piece.offsets)
        outside.voxels[offset] = 0;
    const Volume<float> distance = distanceTo(outside, Sites::all, 1);
    const Vec3& h = piece.box.spacing_m;
    const double half_m = 0.5 * std::min({h.x, h.y, h.z});
    std::vector<double> wall(piece.size());
    for (std::size_t m = 0; m < piece.size(); ++m)
        wall[m] = double(distance.voxels[piece.offsets[m]]) - half_m;
    return wall;
}

std::vector<double> lumenRadius_m(const VoxelPiece& piece, std::span<const double> wall_m) {
    std::vector<double> radius(wall_m.begin(), wall_m.end());
    const std::vector<Neighbour> around = neighbours(piece.box);
    const Vec3& h = piece.box.spacing_m;
    for (std::size_t m = 0; m < piece.size(); ++m) {
        // A ball inside a neighbour's ball covers nothing new.
        const bool covered = std::any_of(around.begin(), around.end(), [&](const Neighbour& n) {
            const std::int32_t next = piece.neighbour(m, n);
            return next != VoxelPiece::kNone && wall_m[std::size_t(next)] >= wall_m[m] + 0.9 * n.length_m;
        });
        if (covered) continue;
        // Extend the ball to the centres of the voxels that it touches.
        const double reach_m = wall_m[m] + std::min({h.x, h.y, h.z});
        const Index3 at = piece.box.voxelAt(piece.offsets[m]);
        const Index3 reach{int(reach_m / h.x), int(reach_m / h.y), int(reach_m / h.z)};
        const Index3 low = glm::max(at - reach, Index3(0)), high = glm::min(at + reach, piece.box.dims - 1);
        forEachVoxel(low, high, [&](const Index3& i) {
            const std::int32_t other = piece.member[i];
            if (other == VoxelPiece::kNone || radius[std::size_t(other)] >= wall_m[m]) return;
            const Vec3 offset_m = h * Vec3(i - at);
            if (glm::dot(offset_m, offset_m) <= reach_m * reach_m) radius[std::size_t(other)] = wall_m[m];
        });
    }
    return radius;
}

}  // namespace stylet
