// Based on Lazarus and Verroust 1999 (level set diagrams). The tube is cut into slices of equal geodesic
// distance from its root. A slice may fall into several connected parts; each part is a node of the
// centre-line tree.
#include "patient/synth/duct_branches.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>

#include "base/geodesic.h"
#include "base/statistics.h"
#include "patient/synth/check_tools.h"

namespace stylet::patient::synth {

namespace {

struct Slice {
    int parent = -1;
    int children = 0;
    double voxels = 0.0;
};

// Distance [mm] of every voxel from the root. The root is the widest place of the largest connected part. In
// the other parts the distance is infinite. `depth_mm` is the result of depthInside().
std::vector<double> distancesFromRoot(const VoxelPiece& tube, const std::vector<double>& depth_mm,
                                      double spacing_mm) {
    const auto step_mm = [&](std::size_t, std::size_t, const Neighbour& n) {
        const Vec3 cells = glm::round(n.step_m / tube.box.spacing_m);
        return spacing_mm * std::sqrt(glm::dot(cells, cells));
    };
    std::vector<std::size_t> by_width(tube.size());
    std::iota(by_width.begin(), by_width.end(), std::size_t(0));
    std::sort(by_width.begin(), by_width.end(), [&](std::size_t a, std::size_t b) {
        return std::tie(depth_mm[b], a) < std::tie(depth_mm[a], b);
    });
    std::vector<double> best;
    std::vector<bool> tried(tube.size());
    std::size_t most = 0;
    for (const std::size_t root : by_width) {
        if (tried[root]) continue;
        const PathStart start{root, 0.0};
        std::vector<double> distance = geodesic_m(tube, {&start, 1}, step_mm);
        std::size_t reached = 0;
        for (std::size_t i = 0; i < tube.size(); ++i)
            if (distance[i] < kUnreached_m) tried[i] = true, ++reached;
        if (reached > most) most = reached, best = std::move(distance);
        if (2 * most >= tube.size()) break;
    }
    return best;
}

// Connected voxels whose distances lie in the same interval of `width_mm` form a slice. A slice's parent
// comes before it.
std::vector<Slice> cutIntoSlices(const VoxelPiece& tube, const std::vector<double>& from_root_mm,
                                 double width_mm) {
    const std::vector<Neighbour> around = neighbours(tube.box);
    std::vector<int> bin(tube.size()), slice(tube.size(), -1);
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < tube.size(); ++i) {
        if (from_root_mm[i] == kUnreached_m) continue;
        bin[i] = int(from_root_mm[i] / width_mm);
        order.push_back(i);
    }
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::tie(from_root_mm[a], a) < std::tie(from_root_mm[b], b);
    });
    std::vector<Slice> found;
    for (const std::size_t start : order) {
        if (slice[start] >= 0) continue;
        const int id = int(found.size());
        Slice& own = found.emplace_back();
        std::vector<std::size_t> stack{start};
        slice[start] = id;
        while (!stack.empty()) {
            const std::size_t i = stack.back();
            stack.pop_back();
            own.voxels += 1.0;
            for (const Neighbour& n : around) {
                const std::int32_t other = tube.neighbour(i, n);
                if (other == VoxelPiece::kNone) continue;
                const auto j = std::size_t(other);
                if (bin[j] == bin[i] && slice[j] < 0)
                    slice[j] = id, stack.push_back(j);
                else if (bin[j] == bin[i] - 1 && own.parent < 0 && slice[j] >= 0)
                    own.parent = slice[j];
            }
        }
    }
    return found;
}

// Removes dead ends of fewer than three slices. They are bumps of the wall, not branches.
void prune(std::vector<Slice>& slices, std::vector<bool>& alive) {
    for (std::size_t i = 0; i < slices.size(); ++i) {
        if (slices[i].children > 0 || slices[i].parent < 0) continue;
        int run = 0, at = int(i);
        while (at >= 0 && slices[std::size_t(at)].children <= 1 && slices[std::size_t(at)].parent >= 0 &&
               run < 3) {
            ++run;
            at = slices[std::size_t(at)].parent;
        }
        if (run >= 3 || at < 0) continue;
        int gone = int(i);
        for (int k = 0; k < run; ++k) {
            alive[std::size_t(gone)] = false;
            gone = slices[std::size_t(gone)].parent;
        }
        --slices[std::size_t(at)].children;
    }
}

}  // namespace

std::vector<double> depthInside(const LabelVolume& labels, const std::vector<std::size_t>& voxels,
                                double limit_mm) {
    const Grid& grid = labels.grid;
    const double spacing = grid.spacing_m.x * 1000.0;
    const std::vector<Offset> ball = ballOffsets(limit_mm / spacing + 1.0);
    std::vector<double> depth(voxels.size());
    for (std::size_t i = 0; i < voxels.size(); ++i) {
        const Index3 at = grid.voxelAt(voxels[i]);
        const std::uint8_t label = labels.voxels[voxels[i]];
        depth[i] = limit_mm;
        for (const Offset& o : ball) {
            const Index3 j = at + o.step;
            if (grid.contains(j) && labels[j] == label) continue;
            depth[i] = std::min(limit_mm, (o.length - 0.5) * spacing);
            break;
        }
    }
    return depth;
}

std::vector<Branch> tubeBranches(const LabelVolume& labels, const std::vector<std::size_t>& voxels) {
    std::vector<Branch> branches;
    if (voxels.empty()) return branches;
    const double spacing_mm = labels.grid.spacing_m.x * 1000.0, width_mm = std::max(2.0, 1.5 * spacing_mm);
    const VoxelPiece tube = makePiece(labels.grid, voxels);
    std::vector<Slice> slices =
        cutIntoSlices(tube, distancesFromRoot(tube, depthInside(labels, voxels, 9.0), spacing_mm), width_mm);
    for (const Slice& s : slices)
        if (s.parent >= 0) ++slices[std::size_t(s.parent)].children;
    std::vector<bool> alive(slices.size(), true);
    prune(slices, alive);
    // A branch ends at a division or a dead end. Walk back from there to its start.
    for (std::size_t i = 0; i < slices.size(); ++i) {
        if (!alive[i] || slices[i].children == 1) continue;
        std::vector<double> diameters;
        for (int k = int(i); k >= 0; k = slices[std::size_t(k)].parent) {
            if (k != int(i) && slices[std::size_t(k)].children != 1) break;
            const double area_mm2 =
                slices[std::size_t(k)].voxels * (spacing_mm * spacing_mm * spacing_mm) / width_mm;
            diameters.push_back(std::sqrt(area_mm2 * 4.0 / 3.14159265358979));
        }
        branches.push_back({double(diameters.size()) * width_mm, upperMedian(diameters)});
    }
    return branches;
}

}  // namespace stylet::patient::synth
