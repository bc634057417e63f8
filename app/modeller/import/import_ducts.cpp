#include "app/modeller/import/import_ducts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "app/modeller/image/cheapest_paths.h"
#include "app/modeller/image/import_image.h"

namespace stylet::modeller {

namespace {

// Masks and distance maps, cropped to the liver and a margin of 12 voxels. The search for ducts uses only
// this crop. The distances are measured to the nearest portal vein, the nearest vessel and the edge of the
// parenchyma.
struct Scene {
    VoxelBox box;  // on the patient's grid
    Mask parenchyma, portal_inside, extrahepatic_portal;
    FloatVolume to_portal, to_vessel, to_edge;  // metres, at voxel centres
};

// A portal voxel counts as inside the liver if at least 30 % of its surroundings are parenchyma.
void splitPortal(const Mask& portal, Scene& s) {
    const FloatVolume share =
        boxMean(toFloat(s.parenchyma), std::max(1, int(0.006 / s.parenchyma.grid.spacing_m.x)));
    s.portal_inside = s.extrahepatic_portal = Mask(s.parenchyma.grid);
    for (std::size_t i = 0; i < portal.voxels.size(); ++i)
        if (portal.voxels[i])
            (share.voxels[i] >= 0.3f ? s.portal_inside : s.extrahepatic_portal).voxels[i] = 1;
}

[[noreturn]] void refuse(const DuctSettings& d, const char* reason) {
    throw ImportError(d.source.string() + ": voxels: " + reason);
}

Scene makeScene(const Mask& parenchyma, const Mask& portal, const Mask& vessels, const DuctSettings& d) {
    Scene s;
    s.box = boxAround(parenchyma, 12);
    if (s.box.empty()) refuse(d, "none is liver: there is nowhere to grow ducts");
    s.parenchyma = cropped(parenchyma, s.box);
    const Mask near_portal = cropped(portal, s.box), near_vessels = cropped(vessels, s.box);
    splitPortal(near_portal, s);
    s.to_portal = distanceTo(near_portal);
    s.to_vessel = distanceTo(near_vessels);
    const Mask elsewhere = maskWhere(
        near_vessels.grid, [&](std::size_t i) { return !s.parenchyma.voxels[i] && !near_vessels.voxels[i]; });
    s.to_edge = distanceTo(elsewhere);
    return s;
}

// `price(offset)` is the cost per metre; negative if impassable.
template <typename Price>
CheapestPaths findPaths(const Grid& g, std::uint32_t seed, const Price& price) {
    const auto extend = [&](float cost, std::uint32_t, std::uint32_t to, double step_m) {
        const float per_m = price(to);
        return per_m < 0.0f ? std::numeric_limits<float>::infinity() : cost + per_m * float(step_m);
    };
    return findCheapestPaths(g, {seed}, extend, [](std::uint32_t, const CheapestPaths&) { return true; });
}

// The point where the portal vein enters the liver: the inside voxel nearest to the trunk outside, or the
// thickest inside voxel if there is no trunk.
std::uint32_t findHilum(const Scene& s, const DuctSettings& d) {
    const FloatVolume to_trunk = distanceTo(s.extrahepatic_portal);
    const Mask background = maskWhere(s.portal_inside.grid, [&](std::size_t i) {
        return !s.portal_inside.voxels[i] && !s.extrahepatic_portal.voxels[i];
    });
    const FloatVolume thickness = distanceTo(background);
    std::uint32_t best = kNoVoxel;
    float best_score = -1e9f;
    for (std::size_t i = 0; i < thickness.voxels.size(); ++i) {
        if (!s.portal_inside.voxels[i]) continue;
        const float score = thickness.voxels[i] - std::min(to_trunk.voxels[i], 0.02f);
        if (score > best_score) best_score = score, best = std::uint32_t(i);
    }
    if (best == kNoVoxel) refuse(d, "no portal vein inside the liver: there is nothing to grow ducts beside");
    return best;
}

double radiusAt(double path_m, double longest, const DuctSettings& d) {
    const double t = std::clamp(path_m / longest, 0.0, 1.0);
    return d.central_radius_m + (d.peripheral_radius_m - d.central_radius_m) * t;
}

// Finds the cheapest paths along the portal tree from the hilum. Gaps between labelled pieces can be crossed
// at a higher cost.
CheapestPaths searchPortal(const Scene& s, std::uint32_t hilum) {
    return findPaths(s.parenchyma.grid, hilum, [&](std::uint32_t o) {
        if (s.portal_inside.voxels[o]) return 1.0f;
        return s.parenchyma.voxels[o] && s.to_portal.voxels[o] < 0.012f ? 4.0f : -1.0f;
    });
}

// Finds the tips of the portal branches. A tip is a portal voxel whose path to the hilum is longer than that
// of all portal voxels around it. Tips closer than `spacing_m` to the path of a tip found earlier are left
// out.
std::vector<std::uint32_t> findTips(const Scene& s, const CheapestPaths& portal, double spacing_m) {
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
        for (std::uint32_t at = o; at != kNoVoxel; at = portal.parent[at]) {
            const Index3 c = g.voxelAt(at);
            forEachVoxel(VoxelBox{c - reach, c + reach}, [&](const Index3& i) {
                if (g.contains(i) && glm::length(g.spacing_m * Vec3(i - c)) <= spacing_m) taken[i] = 1;
            });
        }
    }
    return tips;
}

// The nearest parenchyma voxel within 3 mm of `at` where a peripheral duct fits.
std::uint32_t findRoomNear(const Scene& s, const Vec3& at, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const double room_m = d.peripheral_radius_m + d.gap_m;
    const int reach = std::max(1, int(0.003 / g.spacing_m.x));
    const Index3 c = g.nearest(at);
    std::uint32_t best = kNoVoxel;
    int best_away = 1 << 30;
    forEachVoxel(VoxelBox{c - reach, c + reach}, [&](const Index3& i) {
        const Index3 off = i - c;
        const int away = off.x * off.x + off.y * off.y + off.z * off.z;
        if (away >= best_away || !g.contains(i) || !s.parenchyma[i]) return;
        if (s.to_vessel[i] <= room_m || s.to_edge[i] <= room_m + d.from_capsule_m) return;
        best = std::uint32_t(g.offset(i));
        best_away = away;
    });
    return best;
}

// Returns the voxel at which the duct beside a portal branch ends. The preferred place is up to `beyond_m`
// ahead of the branch's tip. If no duct fits there, the search moves back along the branch. Returns kNoVoxel
// if no duct fits anywhere.
std::uint32_t findDuctEnd(const Scene& s, const CheapestPaths& portal, std::uint32_t tip,
                          const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const auto centre = [&](std::uint32_t o) { return g.centre(g.voxelAt(o)); };
    std::uint32_t back = tip;
    while (portal.parent[back] != kNoVoxel && glm::length(centre(back) - centre(tip)) < 0.010)
        back = portal.parent[back];
    const Vec3 run = centre(tip) - centre(back);
    const Vec3 ahead = glm::length(run) > 0.0 ? glm::normalize(run) : Vec3(0.0);
    for (double beyond = d.beyond_m; beyond > 0.0; beyond -= g.spacing_m.x)
        if (const auto end = findRoomNear(s, centre(tip) + beyond * ahead, d); end != kNoVoxel) return end;
    for (std::uint32_t o = tip; o != kNoVoxel; o = portal.parent[o])
        if (const auto end = findRoomNear(s, centre(o), d); end != kNoVoxel) return end;
    return kNoVoxel;
}

// Finds the cheapest paths from `start` to all voxels of the parenchyma. A voxel is cheap if its distance to
// the portal vein is the duct's radius plus `d.gap_m`. A voxel is expensive if a duct there would come too
// close to any vessel or to the liver's edge. Paths share their segments near `start`, so they form a tree.
CheapestPaths searchDucts(const Scene& s, std::uint32_t start, const Vec3& hilum_m, double longest,
                          const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    return findPaths(g, start, [&](std::uint32_t o) {
        if (!s.parenchyma.voxels[o]) return -1.0f;
        const double from_hilum = glm::length(g.centre(g.voxelAt(o)) - hilum_m);
        const double radius = radiusAt(from_hilum, longest, d), wanted = radius + d.gap_m;
        const double off = (double(s.to_portal.voxels[o]) - wanted) / 0.0015;
        const double vessel = std::max(0.0, wanted - double(s.to_vessel.voxels[o])) / 0.0005;
        const double edge = std::max(0.0, wanted + 0.002 - double(s.to_edge.voxels[o])) / 0.0005;
        return float(1.0 + std::min(off * off, 25.0) + 4.0 * vessel * vessel + 4.0 * edge * edge);
    });
}

std::uint32_t findDuctStart(const Scene& s, std::uint32_t hilum, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    const Vec3 hilum_m = g.centre(g.voxelAt(hilum));
    std::uint32_t best = kNoVoxel;
    double best_score = 1e9;
    for (std::uint32_t o = 0; o < g.voxelCount(); ++o) {
        if (!s.parenchyma.voxels[o]) continue;
        const double away = glm::length(g.centre(g.voxelAt(o)) - hilum_m);
        if (away > 0.03) continue;
        const double tight = std::max(0.0, d.central_radius_m + d.gap_m - double(s.to_vessel.voxels[o])) +
                             std::max(0.0, d.central_radius_m + d.gap_m - double(s.to_edge.voxels[o]));
        const double score = away + 8.0 * tight;
        if (score < best_score) best_score = score, best = o;
    }
    if (best == kNoVoxel) refuse(d, "no liver near the portal vein's entry: ducts have no start");
    return best;
}

struct Point {
    Vec3 at_m;
    double radius_m;
};

// Returns the path to `end` as a curve: its voxel centres, smoothed.
std::vector<Point> traceCurve(const Scene& s, const CheapestPaths& ducts, std::uint32_t end,
                              const std::vector<float>& path_m, double longest, const DuctSettings& d) {
    const Grid& g = s.parenchyma.grid;
    std::vector<Vec3> raw;
    std::vector<double> raw_path_m;
    for (std::uint32_t o = end; o != kNoVoxel; o = ducts.parent[o]) {
        raw.push_back(g.centre(g.voxelAt(o)));
        raw_path_m.push_back(path_m[o]);
    }
    const int n = int(raw.size()), reach = std::max(1, int(0.004 / g.spacing_m.x));
    std::vector<Point> curve;
    for (int i = 0; i < n; ++i) {
        const int k = std::min({reach, i, n - 1 - i});
        Vec3 sum(0.0);
        for (int j = i - k; j <= i + k; ++j)
            sum += raw[std::size_t(j)];
        curve.push_back({sum / double(2 * k + 1), radiusAt(raw_path_m[std::size_t(i)], longest, d)});
    }
    return curve;
}

void stamp(FloatVolume& coverage, const Vec3& at, double radius_m) {
    const Grid& g = coverage.grid;
    const double soft = g.spacing_m.x;
    const Index3 low = glm::max(g.nearest(at - Vec3(radius_m + soft)), Index3(0));
    const Index3 high = glm::min(g.nearest(at + Vec3(radius_m + soft)), g.dims - 1);
    forEachVoxel(VoxelBox{low, high}, [&](const Index3& i) {
        const double away = glm::length(g.centre(i) - at);
        const float share = float(std::clamp(0.5 + (radius_m - away) / soft, 0.0, 1.0));
        float& c = coverage[i];
        c = std::max(c, share);
    });
}

void stampCurve(FloatVolume& coverage, const std::vector<Point>& curve) {
    for (std::size_t i = 0; i + 1 < curve.size(); ++i)
        for (double t : {0.0, 0.5})
            stamp(coverage, glm::mix(curve[i].at_m, curve[i + 1].at_m, t), curve[i].radius_m);
    if (!curve.empty()) stamp(coverage, curve.back().at_m, curve.back().radius_m);
}

// Returns, for each voxel, its distance in metres from the start of the duct tree, measured along the tree.
// Voxels outside the tree have -1.
std::vector<float> pathLengths(const Grid& g, const CheapestPaths& ducts,
                               const std::vector<std::uint32_t>& ends) {
    std::vector<float> path_m(g.voxelCount(), -1.0f);
    std::vector<std::uint32_t> chain;
    for (std::uint32_t end : ends) {
        chain.clear();
        std::uint32_t o = end;
        for (; o != kNoVoxel && path_m[o] < 0.0f; o = ducts.parent[o])
            chain.push_back(o);
        float w = o == kNoVoxel ? 0.0f : path_m[o];
        for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
            if (o != kNoVoxel) w += float(glm::length(g.centre(g.voxelAt(*it)) - g.centre(g.voxelAt(o))));
            path_m[*it] = w;
            o = *it;
        }
    }
    return path_m;
}

}  // namespace

GrownDucts growDucts(const Mask& parenchyma, const Mask& portal, const Mask& vessels, const DuctSettings& d) {
    const Scene s = makeScene(parenchyma, portal, vessels, d);
    const Grid& g = s.parenchyma.grid;
    const std::uint32_t hilum = findHilum(s, d);
    const CheapestPaths portal_paths = searchPortal(s, hilum);
    std::vector<std::uint32_t> ends;
    double longest = 0.03;
    const Vec3 hilum_m = g.centre(g.voxelAt(hilum));
    for (std::uint32_t tip : findTips(s, portal_paths, d.tip_spacing_m)) {
        const std::uint32_t end = findDuctEnd(s, portal_paths, tip, d);
        if (end == kNoVoxel) continue;
        ends.push_back(end);
        longest = std::max(longest, glm::length(g.centre(g.voxelAt(end)) - hilum_m));
    }
    const CheapestPaths ducts = searchDucts(s, findDuctStart(s, hilum, d), hilum_m, longest, d);
    std::erase_if(ends, [&](std::uint32_t end) { return !std::isfinite(ducts.cost[end]); });
    const std::vector<float> path_m = pathLengths(g, ducts, ends);
    double longest_path_m = longest;
    for (std::uint32_t end : ends)
        longest_path_m = std::max(longest_path_m, double(path_m[end]));

    FloatVolume coverage(g);
    for (std::uint32_t end : ends)
        stampCurve(coverage, traceCurve(s, ducts, end, path_m, longest_path_m, d));
    Mask mask =
        maskWhere(g, [&](std::size_t i) { return s.parenchyma.voxels[i] && coverage.voxels[i] >= 0.5f; });
    keepLargestComponent(mask);
    const FloatVolume to_kept = distanceTo(mask);

    GrownDucts out{Mask(parenchyma.grid), FloatVolume(parenchyma.grid), 0, 0.0, 0.0};
    for (std::uint32_t end : ends)
        out.branches += to_kept.voxels[end] < 0.003f;
    for (std::size_t i = 0; i < path_m.size(); ++i)
        if (path_m[i] > 0.0f && ducts.parent[i] != kNoVoxel)
            out.length_m += double(path_m[i]) - double(path_m[ducts.parent[i]]);
    forEachVoxel(g, [&](const Index3& i) {
        const Index3 full = s.box.low + i;
        out.mask[full] = mask[i];
        // keepLargestComponent() dropped small islands from `mask`, but `coverage` still contains them and
        // their partially filled rims. Copy the coverage only near the voxels that were kept.
        if (s.parenchyma[i] && double(to_kept[i]) < 1.8 * g.spacing_m.x) out.coverage[full] = coverage[i];
        out.volume_m3 += mask[i] * g.spacing_m.x * g.spacing_m.y * g.spacing_m.z;
    });
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
