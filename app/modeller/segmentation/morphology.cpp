#include "app/modeller/segmentation/morphology.h"

#include <algorithm>
#include <cmath>

namespace stylet::modeller {

namespace {

VoxelBox widened(VoxelBox b, const Grid& g, double by_m) {
    for (int axis = 0; axis < 3; ++axis) {
        const int by = int(std::ceil(by_m / g.spacing_m[axis])) + 1;
        b.low[axis] = std::max(b.low[axis] - by, 0);
        b.high[axis] = std::min(b.high[axis] + by, g.dims[axis] - 1);
    }
    return b;
}

void dilate(Mask& m, double radius_m) {
    const FloatVolume d = distanceTo(m);
    const float reach = float(radius_m * 1.0001);
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        m.voxels[i] = d.voxels[i] <= reach;
}

void erode(Mask& m, double radius_m) {
    const FloatVolume d = distanceTo(inverted(m));
    const float reach = float(radius_m * 1.0001);
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        m.voxels[i] = m.voxels[i] && d.voxels[i] > reach;
}

// Applies the change to the part of the grid that it can affect.
template <typename Change>
Mask applyInBox(const Mask& m, double reach_m, Change&& change) {
    const VoxelBox box = boundingBox(m);
    Mask out(m.grid);
    if (box.empty()) return out;
    const VoxelBox wide = widened(box, m.grid, reach_m);
    Mask part = cropped(m, wide);
    change(part);
    paste(part, wide.low, out);
    return out;
}

}  // namespace

Mask intersect(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] && b.voxels[i];
    return a;
}

Mask subtract(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] && !b.voxels[i];
    return a;
}

Mask unite(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] || b.voxels[i];
    return a;
}

std::size_t countVoxels(const Mask& m) {
    return m.voxels.size() - std::size_t(std::count(m.voxels.begin(), m.voxels.end(), std::uint8_t{0}));
}

double voxelVolume_ml(const Grid& g) {
    return g.spacing_m.x * g.spacing_m.y * g.spacing_m.z * 1e6;
}

double volume_ml(const Mask& m) {
    return double(countVoxels(m)) * voxelVolume_ml(m.grid);
}

Mask dilated(const Mask& m, double radius_m) {
    return applyInBox(m, radius_m, [&](Mask& part) { dilate(part, radius_m); });
}

Mask eroded(const Mask& m, double radius_m) {
    return applyInBox(m, 0.0, [&](Mask& part) { erode(part, radius_m); });
}

Mask opened(const Mask& m, double radius_m) {
    return applyInBox(m, 0.0, [&](Mask& part) {
        erode(part, radius_m);
        dilate(part, radius_m);
    });
}

Mask closed(const Mask& m, double radius_m) {
    return applyInBox(m, 2.0 * radius_m, [&](Mask& part) {
        dilate(part, radius_m);
        erode(part, radius_m);
    });
}

Mask componentMask(const Components& p, int number) {
    return componentsWhere(p, [&](std::size_t n) { return int(n) == number; });
}

void removeSmallComponents(Mask& m, double min_ml, Connectivity touch) {
    const Components p = findComponents(m, touch);
    const double each_ml = voxelVolume_ml(m.grid);
    m = componentsWhere(p, [&](std::size_t n) { return double(p.size[n]) * each_ml >= min_ml; });
}

void fillCavities(Mask& m) {
    const Grid& g = m.grid;
    const VoxelBox box = boundingBox(m);
    if (box.empty()) return;
    const VoxelBox wide = widened(box, g, 0.0);
    Mask part = cropped(m, wide);
    const Index3 last = part.grid.dims - 1;
    const Mask border = maskWhere(part.grid, [&](std::size_t o) {
        const Index3 i = part.grid.voxelAt(o);
        return i.x == 0 || i.y == 0 || i.z == 0 || i.x == last.x || i.y == last.y || i.z == last.z;
    });
    part = inverted(floodFill(border, inverted(part)));
    paste(part, wide.low, m);
}

LabelVolume growSeeds(const LabelVolume& seeds, const Mask& passable, int max_steps) {
    LabelVolume out = seeds;
    std::vector<std::size_t> front, next;
    for (std::size_t i = 0; i < out.voxels.size(); ++i)
        if (out.voxels[i]) front.push_back(i);
    for (int step = 0; step < max_steps && !front.empty(); ++step) {
        next.clear();
        for (const std::size_t from : front)
            forEachNeighbour(out.grid, out.grid.voxelAt(from), Connectivity::faces, [&](std::size_t to) {
                if (out.voxels[to] || !passable.voxels[to]) return;
                out.voxels[to] = out.voxels[from];
                next.push_back(to);
            });
        front.swap(next);
    }
    return out;
}

}  // namespace stylet::modeller
