#include "app/modeller/import/import_ducts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "app/modeller/image/import_image.h"

namespace stylet::modeller {

namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

// Masks and distance maps, cropped to the liver and a margin of 12 voxels. The search for ducts uses only
// this crop. The distances are measured to the nearest portal vein, the nearest vessel and the edge of the
// parenchyma.
struct Scene {
    Mask parenchyma, portal_inside, portal_outside;
    FloatVolume to_portal, to_vessel, to_edge;  // metres, at voxel centres
};

Grid liverGrid(const Mask& parenchyma, int margin, Index3& from) {
    const Grid& g = parenchyma.grid;
    Index3 low = g.dims, high{-1};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                if (parenchyma[{x, y, z}]) low = glm::min(low, {x, y, z}), high = glm::max(high, {x, y, z});
    if (high.x < 0) throw ImportError("no voxel is liver: there is nowhere to grow ducts");
    from = glm::max(low - margin, Index3(0));
    return {glm::min(high + margin, g.dims - 1) - from + 1, g.spacing_m, g.centre(from)};
}

Mask cropped(const Mask& in, const Grid& grid, const Index3& from) {
    Mask out(grid);
    for (int z = 0; z < grid.dims.z; ++z)
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x)
                out[{x, y, z}] = in[from + Index3{x, y, z}];
    return out;
}

// A portal voxel counts as inside the liver if at least 30 % of its surroundings are parenchyma.
void splitPortal(const Mask& portal, Scene& s) {
    FloatVolume solid(s.parenchyma.grid);
    for (std::size_t i = 0; i < solid.voxels.size(); ++i)
        solid.voxels[i] = s.parenchyma.voxels[i];
    const FloatVolume share = boxMean(solid, std::max(1, int(0.006 / s.parenchyma.grid.spacing_m.x)));
    s.portal_inside = s.portal_outside = Mask(s.parenchyma.grid);
    for (std::size_t i = 0; i < solid.voxels.size(); ++i)
        if (portal.voxels[i]) (share.voxels[i] >= 0.3f ? s.portal_inside : s.portal_outside).voxels[i] = 1;
}

Scene makeScene(const Mask& parenchyma, const Mask& portal, const Mask& vessels) {
    Index3 from;
    const Grid grid = liverGrid(parenchyma, 12, from);
    Scene s;
    s.parenchyma = cropped(parenchyma, grid, from);
    const Mask near_portal = cropped(portal, grid, from), near_vessels = cropped(vessels, grid, from);
    splitPortal(near_portal, s);
    s.to_portal = distanceTo(near_portal);
    s.to_vessel = distanceTo(near_vessels);
    Mask elsewhere(grid);
    for (std::size_t i = 0; i < elsewhere.voxels.size(); ++i)
        elsewhere.voxels[i] = !s.parenchyma.voxels[i] && !near_vessels.voxels[i];
    s.to_edge = distanceTo(elsewhere);
    return s;
}

struct Search {
    std::vector<float> cost;
    std::vector<std::uint32_t> parent;
};

// Dijkstra's algorithm over 26 neighbours. `price(offset)` is the cost per metre; negative if impassable.
template <typename Price>
Search cheapestFrom(const Grid& g, const std::vector<std::uint32_t>& seeds, Price&& price) {
    Search s{std::vector<float>(g.voxelCount(), std::numeric_limits<float>::infinity()),
             std::vector<std::uint32_t>(g.voxelCount(), kNobody)};
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    for (std::uint32_t o : seeds)
        s.cost[o] = 0.0f, open.push({0.0f, o});
    while (!open.empty()) {
        const auto [cost, o] = open.top();
        open.pop();
        if (cost > s.cost[o]) continue;
        const int x = int(o) % g.dims.x, y = int(o) / g.dims.x % g.dims.y, z = int(o) / (g.dims.x * g.dims.y);
        for (int dz = -1; dz <= 1; ++dz)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const Index3 to{x + dx, y + dy, z + dz};
                    if (!g.contains(to)) continue;
                    const auto t = std::uint32_t(g.offset(to));
                    const float per_m = price(t);
                    if (per_m < 0.0f) continue;
                    const float next = cost + per_m * float(glm::length(g.spacing_m * Vec3(dx, dy, dz)));
                    if (next >= s.cost[t]) continue;
                    s.cost[t] = next;
                    s.parent[t] = o;
                    open.push({next, t});
                }
    }
    return s;
}

Index3 voxelOf(const Grid& g, std::uint32_t o) {
    return {int(o) % g.dims.x, int(o) / g.dims.x % g.dims.y, int(o) / (g.dims.x * g.dims.y)};
}

// The point where the portal vein enters the liver: the inside voxel nearest to the trunk outside, or the
// thickest inside voxel if there is no trunk.
std::uint32_t hilumOf(const Scene& s) {
    const FloatVolume to_trunk = distanceTo(s.portal_outside);
    Mask background(s.portal_inside.grid);
    for (std::size_t i = 0; i < background.voxels.size(); ++i)
        background.voxels[i] = !s.portal_inside.voxels[i] && !s.portal_outside.voxels[i];
    const FloatVolume thickness = distanceTo(background);
    std::uint32_t best = kNobody;
    float best_score = -1e9f;
    for (std::size_t i = 0; i < thickness.voxels.size(); ++i) {
        if (!s.portal_inside.voxels[i]) continue;
        const float score = thickness.voxels[i] - std::min(to_trunk.voxels[i], 0.02f);
        if (score > best_score) best_score = score, best = std::uint32_t(i);
    }
    if (best == kNobody)
        throw ImportError("no portal vein inside the liver: there is nothing to grow ducts beside");
    return best;
}

double radiusAt(double way, double longest, const DuctSettings& d) {
    const double t = std::clamp(way / longest, 0.0, 1.0);
    return d.central_radius_m + (d.peripheral_radius_m - d.central_radius_m) * t;
}

// Path cost along the portal tree from the hilum. Gaps between labelled pieces can be crossed at a higher
// cost.
Search alongPortal(const Scene& s, std::uint32_t hilum) {
    return cheapestFrom(s.parenchyma.grid, {hilum}, [&](std::uint32_t o) {
        if (s.portal_inside.voxels[o]) return 1.0f;
        return s.parenchyma.voxels[o] && s.to_portal.voxels[o] < 0.012f ? 4.0f : -1.0f;
    });
}

// Finds the tips of the portal branches. A tip is a portal voxel whose path to the hilum is longer than that
// of all portal voxels around it. Tips closer than `spacing_m` to the path of a tip found earlier are left
// out.
std::vector<std::uint32_t> tipsOf(const Scene& s, const Search& portal, double spacing_m) {
    const Grid& g = s.parenchyma.grid;
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < g.voxelCount(); ++i)
        if (s.portal_inside.voxels[i] && std::isfinite(portal.cost[i])) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return portal.cost[a] != portal.cost[b] ? portal.cost[a] > portal.cost[b] : a < b;
    });
    Mask taken(g);
    std::vector<std::uint32_t> tips;
    const int reach = int(std::ceil(spacing_m / g.spacing_m.x));
    for (std::uint32_t o : order) {
        if (taken.voxels[o]) continue;
        tips.push_back(o);
        // Follow the path from this tip to the hilum. Mark all voxels within `spacing_m` of the path, so that
        // they do not become tips.
        for (std::uint32_t at = o; at != kNobody; at = portal.parent[at]) {
            const Index3 c = voxelOf(g, at);
            for (int dz = -reach; dz <= reach; ++dz)
                for (int dy = -reach; dy <= reach; ++dy)
                    for (int dx = -reach; dx <= reach; ++dx) {
                        const Index3 i = c + Index3{dx, dy, dz};
                        if (g.contains(i) && glm::length(g.spacing_m * Vec3(dx, dy, dz)) <= spacing_m)
                            taken[i] = 1;
                    }
        }
    }
    return tips;
}

// The nearest parenchyma voxel within 3 mm of `at` where a peripheral duct fits.
std::uint32_t roomNear(const Scene& s, const Vec3& at, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const double room_m = d.peripheral_radius_m + d.gap_m;
    const int reach = std::max(1, int(0.003 / g.spacing_m.x));
    const Index3 c = g.nearest(at);
    std::uint32_t best = kNobody;
    int best_away = 1 << 30;
    for (int dz = -reach; dz <= reach; ++dz)
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
                const Index3 i = c + Index3{dx, dy, dz};
                const int away = dx * dx + dy * dy + dz * dz;
                if (away >= best_away || !g.contains(i) || !s.parenchyma[i]) continue;
                if (s.to_vessel[i] <= room_m || s.to_edge[i] <= room_m + d.from_capsule_m) continue;
                best = std::uint32_t(g.offset(i));
                best_away = away;
            }
    return best;
}

// Returns the voxel at which the duct beside a portal branch ends. The preferred place is up to `beyond_m`
// ahead of the branch's tip. If no duct fits there, the search moves back along the branch. Returns kNobody
// if no duct fits anywhere.
std::uint32_t ductEnd(const Scene& s, const Search& portal, std::uint32_t tip, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const auto centre = [&](std::uint32_t o) { return g.centre(voxelOf(g, o)); };
    std::uint32_t back = tip;
    while (portal.parent[back] != kNobody && glm::length(centre(back) - centre(tip)) < 0.010)
        back = portal.parent[back];
    const Vec3 run = centre(tip) - centre(back);
    const Vec3 ahead = glm::length(run) > 0.0 ? glm::normalize(run) : Vec3(0.0);
    for (double beyond = d.beyond_m; beyond > 0.0; beyond -= g.spacing_m.x)
        if (const auto end = roomNear(s, centre(tip) + beyond * ahead, d); end != kNobody) return end;
    for (std::uint32_t o = tip; o != kNobody; o = portal.parent[o])
        if (const auto end = roomNear(s, centre(o), d); end != kNobody) return end;
    return kNobody;
}

// Finds the cheapest paths from `start` to all voxels of the parenchyma. A voxel is cheap if its distance to
// the portal vein is the duct's radius plus `d.gap_m`. A voxel is expensive if a duct there would come too
// close to any vessel or to the liver's edge. Paths share their segments near `start`, so they form a tree.
Search alongDucts(const Scene& s, std::uint32_t start, const Vec3& hilum_m, double longest,
                  const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    return cheapestFrom(g, {start}, [&](std::uint32_t o) {
        if (!s.parenchyma.voxels[o]) return -1.0f;
        const double from_hilum = glm::length(g.centre(voxelOf(g, o)) - hilum_m);
        const double radius = radiusAt(from_hilum, longest, d), wanted = radius + d.gap_m;
        const double off = (double(s.to_portal.voxels[o]) - wanted) / 0.0015;
        const double vessel = std::max(0.0, wanted - double(s.to_vessel.voxels[o])) / 0.0005;
        const double edge = std::max(0.0, wanted + 0.002 - double(s.to_edge.voxels[o])) / 0.0005;
        return float(1.0 + std::min(off * off, 25.0) + 4.0 * vessel * vessel + 4.0 * edge * edge);
    });
}

std::uint32_t ductStart(const Scene& s, std::uint32_t hilum, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const Vec3 hilum_m = g.centre(voxelOf(g, hilum));
    std::uint32_t best = kNobody;
    double best_score = 1e9;
    for (std::uint32_t o = 0; o < g.voxelCount(); ++o) {
        if (!s.parenchyma.voxels[o]) continue;
        const double away = glm::length(g.centre(voxelOf(g, o)) - hilum_m);
        if (away > 0.03) continue;
        const double tight = std::max(0.0, d.central_radius_m + d.gap_m - double(s.to_vessel.voxels[o])) +
                             std::max(0.0, d.central_radius_m + d.gap_m - double(s.to_edge.voxels[o]));
        const double score = away + 8.0 * tight;
        if (score < best_score) best_score = score, best = o;
    }
    if (best == kNobody) throw ImportError("no liver near the portal vein's entry: ducts have no start");
    return best;
}

struct Point {
    Vec3 at_m;
    double radius_m;
};

// The path as a curve: its voxel centres, smoothed.
std::vector<Point> curveTo(const Scene& s, const Search& ducts, std::uint32_t end,
                           const std::vector<float>& way, double longest, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    std::vector<Vec3> raw;
    std::vector<double> at_way;
    for (std::uint32_t o = end; o != kNobody; o = ducts.parent[o]) {
        raw.push_back(g.centre(voxelOf(g, o)));
        at_way.push_back(way[o]);
    }
    const int n = int(raw.size()), reach = std::max(1, int(0.004 / g.spacing_m.x));
    std::vector<Point> curve;
    for (int i = 0; i < n; ++i) {
        const int k = std::min({reach, i, n - 1 - i});
        Vec3 sum(0.0);
        for (int j = i - k; j <= i + k; ++j)
            sum += raw[std::size_t(j)];
        curve.push_back({sum / double(2 * k + 1), radiusAt(at_way[std::size_t(i)], longest, d)});
    }
    return curve;
}

void stamp(FloatVolume& coverage, const Vec3& at, double radius_m) {
    const Grid& g = coverage.grid;
    const double soft = g.spacing_m.x;
    const Index3 low = glm::max(g.nearest(at - Vec3(radius_m + soft)), Index3(0));
    const Index3 high = glm::min(g.nearest(at + Vec3(radius_m + soft)), g.dims - 1);
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const double away = glm::length(g.centre({x, y, z}) - at);
                const float share = float(std::clamp(0.5 + (radius_m - away) / soft, 0.0, 1.0));
                float& c = coverage[{x, y, z}];
                c = std::max(c, share);
            }
}

void stampCurve(FloatVolume& coverage, const std::vector<Point>& curve) {
    for (std::size_t i = 0; i + 1 < curve.size(); ++i)
        for (double t : {0.0, 0.5})
            stamp(coverage, glm::mix(curve[i].at_m, curve[i + 1].at_m, t), curve[i].radius_m);
    if (!curve.empty()) stamp(coverage, curve.back().at_m, curve.back().radius_m);
}

// Returns, for each voxel, its distance in metres from the start of the duct tree, measured along the tree.
// Voxels outside the tree have -1.
std::vector<float> wayAlong(const Grid& g, const Search& ducts, const std::vector<std::uint32_t>& ends) {
    std::vector<float> way(g.voxelCount(), -1.0f);
    std::vector<std::uint32_t> chain;
    for (std::uint32_t end : ends) {
        chain.clear();
        std::uint32_t o = end;
        for (; o != kNobody && way[o] < 0.0f; o = ducts.parent[o])
            chain.push_back(o);
        float w = o == kNobody ? 0.0f : way[o];
        for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
            if (o != kNobody) w += float(glm::length(g.centre(voxelOf(g, *it)) - g.centre(voxelOf(g, o))));
            way[*it] = w;
            o = *it;
        }
    }
    return way;
}

}  // namespace

GrownDucts growDucts(const Mask& parenchyma, const Mask& portal, const Mask& vessels, const DuctSettings& d) {
    const Scene s = makeScene(parenchyma, portal, vessels);
    const Grid& g = s.parenchyma.grid;
    const std::uint32_t hilum = hilumOf(s);
    const Search portal_ways = alongPortal(s, hilum);
    std::vector<std::uint32_t> ends;
    double longest = 0.03;
    const Vec3 hilum_m = g.centre(voxelOf(g, hilum));
    for (std::uint32_t tip : tipsOf(s, portal_ways, d.tip_spacing_m)) {
        const std::uint32_t end = ductEnd(s, portal_ways, tip, d);
        if (end == kNobody) continue;
        ends.push_back(end);
        longest = std::max(longest, glm::length(g.centre(voxelOf(g, end)) - hilum_m));
    }
    const Search ducts = alongDucts(s, ductStart(s, hilum, d), hilum_m, longest, d);
    std::erase_if(ends, [&](std::uint32_t end) { return !std::isfinite(ducts.cost[end]); });
    const std::vector<float> way = wayAlong(g, ducts, ends);
    double longest_way = longest;
    for (std::uint32_t end : ends)
        longest_way = std::max(longest_way, double(way[end]));

    FloatVolume coverage(g);
    for (std::uint32_t end : ends)
        stampCurve(coverage, curveTo(s, ducts, end, way, longest_way, d));
    Mask mask(g);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = s.parenchyma.voxels[i] && coverage.voxels[i] >= 0.5f;
    keepLargest(mask);
    const FloatVolume to_kept = distanceTo(mask);

    GrownDucts out{Mask(parenchyma.grid), FloatVolume(parenchyma.grid), 0, 0.0, 0.0};
    for (std::uint32_t end : ends)
        out.branches += to_kept.voxels[end] < 0.003f;
    for (std::size_t i = 0; i < way.size(); ++i)
        if (way[i] > 0.0f && ducts.parent[i] != kNobody)
            out.length_m += double(way[i]) - double(way[ducts.parent[i]]);
    const Index3 from = parenchyma.grid.nearest(g.origin_m);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z}, full = from + i;
                out.mask[full] = mask[i];
                // keepLargest() dropped small islands from `mask`, but `coverage` still contains them and
                // their partially filled rims. Copy the coverage only near the voxels that were kept.
                if (s.parenchyma[i] && double(to_kept[i]) < 1.8 * g.spacing_m.x)
                    out.coverage[full] = coverage[i];
                out.volume_m3 += mask[i] * g.spacing_m.x * g.spacing_m.y * g.spacing_m.z;
            }
    return out;
}

void paintBile(CtVolume& ct, const GrownDucts& ducts, const Mask& parenchyma, double bile_hu) {
    FloatVolume tissue(ct.grid), solid(ct.grid);
    for (std::size_t i = 0; i < tissue.voxels.size(); ++i)
        if (parenchyma.voxels[i]) tissue.voxels[i] = float(ct.voxels[i]), solid.voxels[i] = 1.0f;
    tissue = boxMean(tissue, 2);
    solid = boxMean(solid, 2);
    for (std::size_t i = 0; i < tissue.voxels.size(); ++i) {
        const double share = double(ducts.coverage.voxels[i]);
        if (share <= 0.0 || !parenchyma.voxels[i]) continue;
        const double mean = double(tissue.voxels[i]) / double(solid.voxels[i]);
        const double noise = double(ct.voxels[i]) - mean;
        ct.voxels[i] = std::int16_t(std::lround(share * bile_hu + (1.0 - share) * mean + noise));
    }
}

}  // namespace stylet::modeller
