// Based on Lazarus and Verroust 1999 (level set diagrams). The tube is cut into slices of equal geodesic
// distance from its root. Connected slices are the nodes of its centre-line tree.
#include "patient/synth/duct_branches.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <unordered_map>

#include "base/statistics.h"
#include "patient/synth/check_tools.h"

namespace stylet::patient::synth {

namespace {

constexpr double kUnreached = 1e30;

struct Slice {
    int parent = -1;
    int children = 0;
    double voxels = 0.0;
};

class LevelSets {
  public:
    LevelSets(const LabelVolume& labels, const std::vector<std::size_t>& voxels)
        : grid_(labels.grid), voxels_(voxels), spacing_mm_(labels.grid.spacing_m.x * 1000.0) {
        index_.reserve(voxels.size() * 2);
        for (std::size_t i = 0; i < voxels.size(); ++i)
            index_[voxels[i]] = int(i);
        depth_ = depthInside(labels, voxels, 9.0);
    }

    std::vector<Slice> slices() {
        spread();
        const double width = std::max(2.0, 1.5 * spacing_mm_);
        std::vector<int> bin(voxels_.size()), slice(voxels_.size(), -1);
        // From the root outwards, so that a slice's parent is known first.
        std::vector<int> order;
        for (std::size_t i = 0; i < bin.size(); ++i) {
            if (from_root_[i] >= kUnreached) continue;
            bin[i] = int(from_root_[i] / width);
            order.push_back(int(i));
        }
        std::sort(order.begin(), order.end(), [&](int a, int b) {
            const auto l = std::size_t(a), r = std::size_t(b);
            return from_root_[l] != from_root_[r] ? from_root_[l] < from_root_[r] : a < b;
        });
        std::vector<Slice> found;
        for (const int start : order) {
            if (slice[std::size_t(start)] >= 0) continue;
            const int id = int(found.size());
            found.push_back({});
            std::vector<int> stack{start};
            slice[std::size_t(start)] = id;
            while (!stack.empty()) {
                const int i = stack.back();
                stack.pop_back();
                found[std::size_t(id)].voxels += 1.0;
                eachNeighbour(i, [&](int j, double) {
                    if (bin[std::size_t(j)] == bin[std::size_t(i)] && slice[std::size_t(j)] < 0) {
                        slice[std::size_t(j)] = id;
                        stack.push_back(j);
                    } else if (bin[std::size_t(j)] == bin[std::size_t(i)] - 1 &&
                               found[std::size_t(id)].parent < 0 && slice[std::size_t(j)] >= 0) {
                        found[std::size_t(id)].parent = slice[std::size_t(j)];
                    }
                });
            }
        }
        width_mm_ = width;
        return found;
    }

    double width_mm() const { return width_mm_; }
    double voxel_mm3() const { return spacing_mm_ * spacing_mm_ * spacing_mm_; }

  private:
    template <class Visit>
    void eachNeighbour(int i, const Visit& visit) const {
        const Index3 at = grid_.voxelAt(voxels_[std::size_t(i)]);
        for (int dz = -1; dz <= 1; ++dz)
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const Index3 j{at.x + dx, at.y + dy, at.z + dz};
                    if (!grid_.contains(j)) continue;
                    const auto hit = index_.find(grid_.offset(j));
                    if (hit == index_.end() || hit->second == i) continue;
                    visit(hit->second, spacing_mm_ * std::sqrt(double(dx * dx + dy * dy + dz * dz)));
                }
    }

    // Geodesic distance from the root: the widest place of the largest piece.
    void spread() {
        from_root_.assign(voxels_.size(), kUnreached);
        std::vector<int> by_width(voxels_.size());
        for (std::size_t i = 0; i < by_width.size(); ++i)
            by_width[i] = int(i);
        std::sort(by_width.begin(), by_width.end(), [&](int a, int b) {
            const double l = depth_[std::size_t(a)], r = depth_[std::size_t(b)];
            return l != r ? l > r : a < b;
        });
        std::vector<double> best;
        std::size_t most = 0;
        for (const int root : by_width) {
            if (from_root_[std::size_t(root)] < kUnreached) continue;
            const std::vector<double> before = from_root_;
            const std::size_t reached = spreadFrom(root);
            if (reached <= most) continue;
            most = reached;
            best = from_root_;
            for (std::size_t i = 0; i < best.size(); ++i)
                if (before[i] < kUnreached) best[i] = kUnreached;
            if (2 * most >= voxels_.size()) break;
        }
        from_root_ = best;
    }

    std::size_t spreadFrom(int root) {
        using Entry = std::pair<double, int>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        std::size_t reached = 0;
        from_root_[std::size_t(root)] = 0.0;
        open.push({0.0, root});
        while (!open.empty()) {
            const auto [d, i] = open.top();
            open.pop();
            if (d > from_root_[std::size_t(i)]) continue;
            ++reached;
            const double here = d;
            eachNeighbour(i, [&](int j, double step) {
                if (here + step >= from_root_[std::size_t(j)]) return;
                from_root_[std::size_t(j)] = here + step;
                open.push({here + step, j});
            });
        }
        return reached;
    }

    const Grid& grid_;
    const std::vector<std::size_t>& voxels_;
    double spacing_mm_, width_mm_ = 1.0;
    std::unordered_map<std::size_t, int> index_;
    std::vector<double> depth_, from_root_;
};

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
    LevelSets sets(labels, voxels);
    std::vector<Slice> slices = sets.slices();
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
            const double area_mm2 = slices[std::size_t(k)].voxels * sets.voxel_mm3() / sets.width_mm();
            diameters.push_back(std::sqrt(area_mm2 * 4.0 / 3.14159265358979));
        }
        branches.push_back({double(diameters.size()) * sets.width_mm(), upperMedian(diameters)});
    }
    return branches;
}

}  // namespace stylet::patient::synth
