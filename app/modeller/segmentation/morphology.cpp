#include "app/modeller/segmentation/morphology.h"

#include <algorithm>
#include <cmath>

namespace stylet::modeller {

namespace {

constexpr Index3 kFaces[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

template <typename F>
void forEachNeighbour(const Grid& g, const Index3& at, Touch touch, F&& f) {
    if (touch == Touch::faces) {
        for (const Index3& step : kFaces)
            if (g.contains(at + step)) f(g.offset(at + step));
        return;
    }
    for (int z = std::max(at.z - 1, 0); z <= std::min(at.z + 1, g.dims.z - 1); ++z)
        for (int y = std::max(at.y - 1, 0); y <= std::min(at.y + 1, g.dims.y - 1); ++y)
            for (int x = std::max(at.x - 1, 0); x <= std::min(at.x + 1, g.dims.x - 1); ++x)
                if (Index3(x, y, z) != at) f(g.offset({x, y, z}));
}

VoxelBox widened(VoxelBox b, const Grid& g, double by_m) {
    for (int axis = 0; axis < 3; ++axis) {
        const int by = int(std::ceil(by_m / g.spacing_m[axis])) + 1;
        b.low[axis] = std::max(b.low[axis] - by, 0);
        b.high[axis] = std::min(b.high[axis] + by, g.dims[axis] - 1);
    }
    return b;
}

void paste(const Mask& part, const VoxelBox& b, Mask& into) {
    const Grid& g = part.grid;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            const auto from = part.voxels.begin() + std::ptrdiff_t(g.offset({0, y, z}));
            std::copy(from, from + g.dims.x,
                      into.voxels.begin() + std::ptrdiff_t(into.grid.offset(b.low + Index3(0, y, z))));
        }
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
Mask changed(const Mask& m, double reach_m, Change&& change) {
    const VoxelBox box = boxOf(m);
    Mask out(m.grid);
    if (box.empty()) return out;
    const VoxelBox wide = widened(box, m.grid, reach_m);
    Mask part = cropped(m, wide);
    change(part);
    paste(part, wide, out);
    return out;
}

}  // namespace

Mask both(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] && b.voxels[i];
    return a;
}

Mask without(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] && !b.voxels[i];
    return a;
}

Mask either(Mask a, const Mask& b) {
    for (std::size_t i = 0; i < a.voxels.size(); ++i)
        a.voxels[i] = a.voxels[i] || b.voxels[i];
    return a;
}

std::size_t countOf(const Mask& m) {
    return m.voxels.size() - std::size_t(std::count(m.voxels.begin(), m.voxels.end(), std::uint8_t{0}));
}

double voxelVolume_ml(const Grid& g) {
    return g.spacing_m.x * g.spacing_m.y * g.spacing_m.z * 1e6;
}

double volume_ml(const Mask& m) {
    return double(countOf(m)) * voxelVolume_ml(m.grid);
}

VoxelBox boxOf(const Mask& m) {
    const Grid& g = m.grid;
    VoxelBox b{g.dims, Index3(-1)};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            const std::uint8_t* row = m.voxels.data() + g.offset({0, y, z});
            const std::uint8_t* end = row + g.dims.x;
            const std::uint8_t* first = std::find_if(row, end, [](std::uint8_t v) { return v != 0; });
            if (first == end) continue;
            int last = g.dims.x - 1;
            while (!row[last])
                --last;
            b.low = glm::min(b.low, Index3(int(first - row), y, z));
            b.high = glm::max(b.high, Index3(last, y, z));
        }
    if (b.high.x < 0) return {Index3(0), Index3(-1)};
    return b;
}

Mask cropped(const Mask& m, const VoxelBox& b) {
    Grid g = m.grid;
    g.origin_m = m.grid.centre(b.low);
    g.dims = b.high - b.low + 1;
    Mask out(g);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            const auto from = m.voxels.begin() + std::ptrdiff_t(m.grid.offset(b.low + Index3(0, y, z)));
            std::copy(from, from + g.dims.x, out.voxels.begin() + std::ptrdiff_t(g.offset({0, y, z})));
        }
    return out;
}

Mask dilated(const Mask& m, double radius_m) {
    return changed(m, radius_m, [&](Mask& part) { dilate(part, radius_m); });
}

Mask eroded(const Mask& m, double radius_m) {
    return changed(m, 0.0, [&](Mask& part) { erode(part, radius_m); });
}

Mask opened(const Mask& m, double radius_m) {
    return changed(m, 0.0, [&](Mask& part) {
        erode(part, radius_m);
        dilate(part, radius_m);
    });
}

Mask closed(const Mask& m, double radius_m) {
    return changed(m, 2.0 * radius_m, [&](Mask& part) {
        dilate(part, radius_m);
        erode(part, radius_m);
    });
}

int Pieces::largest() const {
    if (size.size() < 2) return 0;
    return int(std::max_element(size.begin() + 1, size.end()) - size.begin());
}

Pieces piecesOf(const Mask& m, Touch touch) {
    Pieces p{Volume<std::int32_t>(m.grid), {0}};
    std::vector<std::size_t> open;
    for (std::size_t seed = 0; seed < m.voxels.size(); ++seed) {
        if (!m.voxels[seed] || p.number.voxels[seed]) continue;
        const auto number = std::int32_t(p.size.size());
        p.size.push_back(0);
        p.number.voxels[seed] = number;
        open.assign(1, seed);
        while (!open.empty()) {
            const Index3 at = m.grid.voxelAt(open.back());
            open.pop_back();
            ++p.size.back();
            forEachNeighbour(m.grid, at, touch, [&](std::size_t to) {
                if (!m.voxels[to] || p.number.voxels[to]) return;
                p.number.voxels[to] = number;
                open.push_back(to);
            });
        }
    }
    return p;
}

Mask pieceOf(const Pieces& p, int number) {
    Mask m(p.number.grid);
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        m.voxels[i] = p.number.voxels[i] != 0 && p.number.voxels[i] == number;
    return m;
}

void dropSmall(Mask& m, double least_ml, Touch touch) {
    const Pieces p = piecesOf(m, touch);
    const double each_ml = voxelVolume_ml(m.grid);
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        if (m.voxels[i] && double(p.size[std::size_t(p.number.voxels[i])]) * each_ml < least_ml)
            m.voxels[i] = 0;
}

Mask piecesWith(const Mask& m, const Mask& seeds) {
    return floodFrom(seeds, m);
}

void fillCavities(Mask& m) {
    const Grid& g = m.grid;
    const VoxelBox box = boxOf(m);
    if (box.empty()) return;
    const VoxelBox wide = widened(box, g, 0.0);
    Mask part = cropped(m, wide);
    Mask border(part.grid);
    for (int z = 0; z < part.grid.dims.z; ++z)
        for (int y = 0; y < part.grid.dims.y; ++y)
            for (int x = 0; x < part.grid.dims.x; ++x)
                border[{x, y, z}] = x == 0 || y == 0 || z == 0 || x == part.grid.dims.x - 1 ||
                                    y == part.grid.dims.y - 1 || z == part.grid.dims.z - 1;
    part = inverted(floodFrom(border, inverted(part)));
    paste(part, wide, m);
}

LabelVolume growSeeds(const LabelVolume& seeds, const Mask& passable, int most_steps) {
    LabelVolume out = seeds;
    std::vector<std::size_t> front, next;
    for (std::size_t i = 0; i < out.voxels.size(); ++i)
        if (out.voxels[i]) front.push_back(i);
    for (int step = 0; step < most_steps && !front.empty(); ++step) {
        next.clear();
        for (const std::size_t from : front)
            forEachNeighbour(out.grid, out.grid.voxelAt(from), Touch::faces, [&](std::size_t to) {
                if (out.voxels[to] || !passable.voxels[to]) return;
                out.voxels[to] = out.voxels[from];
                next.push_back(to);
            });
        front.swap(next);
    }
    return out;
}

}  // namespace stylet::modeller
