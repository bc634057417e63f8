// Cheapest paths through a volume, over the 26 neighbours of a voxel.
// Based on Dijkstra, "A note on two problems in connexion with graphs", Numer. Math. 1, 1959.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

inline constexpr std::uint32_t kNoVoxel = std::numeric_limits<std::uint32_t>::max();

// For each voxel, indexed by its offset: the cost of its cheapest path from a seed (infinite if there is
// none), and the previous voxel on that path (kNoVoxel for a seed).
struct CheapestPaths {
    std::vector<float> cost;
    std::vector<std::uint32_t> parent;
};

// `extend(cost, from, to, step_m)` returns the cost of a path that is extended by one step; infinite if the
// step is impassable. `settle(voxel, paths)` is called when the path to a voxel is final, cheapest first; the
// search ends when it returns false.
template <typename Extend, typename Settle>
CheapestPaths findCheapestPaths(const Grid& g, const std::vector<std::uint32_t>& seeds, const Extend& extend,
                                const Settle& settle) {
    CheapestPaths paths{std::vector<float>(g.voxelCount(), std::numeric_limits<float>::infinity()),
                        std::vector<std::uint32_t>(g.voxelCount(), kNoVoxel)};
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    for (const std::uint32_t seed : seeds)
        paths.cost[seed] = 0.0f, open.push({0.0f, seed});
    while (!open.empty()) {
        const float cost = open.top().first;
        const std::uint32_t from = open.top().second;
        open.pop();
        if (cost > paths.cost[from]) continue;
        if (!settle(from, paths)) break;
        const Index3 at = g.voxelAt(from);
        forEachVoxel(boxAround(g, at, 1), [&](const Index3& i) {
            if (i == at) return;
            const auto to = std::uint32_t(g.offset(i));
            const float next = extend(cost, from, to, glm::length(g.spacing_m * Vec3(i - at)));
            if (next >= paths.cost[to]) return;
            paths.cost[to] = next;
            paths.parent[to] = from;
            open.push({next, to});
        });
    }
    return paths;
}

}  // namespace stylet::modeller
