#include "app/modeller/image/morphology.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/modeller/image/mask_runs.h"
#include "base/parallel.h"

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

constexpr float kFar = 1e6f;  // squared metres

// Squared distance along x from each voxel of a row to the nearest voxel of the mask in it. If there is none,
// returns false, and `out` is not valid.
bool distanceAlongRow(const std::uint8_t* mask, int n, float spacing_m, float* out) {
    if (!stepsAlongRow(mask, n, out)) return false;
    std::transform(out, out + n, out, [=](float steps) { return (steps * spacing_m) * (steps * spacing_m); });
    return true;
}

void lowerTo(float* values, const float* others, float by, int n) {
    for (int x = 0; x < n; ++x)
        values[x] = std::min(values[x], others[x] + by);
}

// Row i of the squared distances along one more axis: the minimum over the rows k within `reach` of
// rows(k) + (spacing (k - i))^2. rows(k) is null if the row has no value. If all are null, returns false, and
// `out` is not valid.
template <typename Rows>
bool minimumOfRows(const Rows& rows, int i, int count, int reach, float spacing_m, float* out, int n) {
    bool any = false;
    for (int k = std::max(0, i - reach); k <= std::min(count - 1, i + reach); ++k) {
        const float* const row = rows(k);
        if (!row) continue;
        if (!any) std::fill(out, out + n, kFar);
        any = true;
        const float d_m = float(k - i) * spacing_m;
        lowerTo(out, row, d_m * d_m, n);
    }
    return any;
}

// The voxels within the radius of the mask. Minimises squared distances axis by axis, as distanceTo() does,
// but only within the radius. Each step is the minimum of two rows, which the compiler vectorises.
Mask voxelsWithin(const Mask& m, double radius_m) {
    const Grid& g = m.grid;
    const float reach_m = float(radius_m * 1.0001), reach2_m2 = reach_m * reach_m;
    const auto steps = [&](int axis) { return int(double(reach_m) / g.spacing_m[axis]); };
    const std::size_t length = std::size_t(g.dims.x), slice = length * std::size_t(g.dims.y);
    FloatVolume in_plane(g);
    std::vector<std::uint8_t> has_value(std::size_t(g.dims.y) * std::size_t(g.dims.z));  // by row
    const auto rowIndex = [&](int y, int z) {
        return std::size_t(z) * std::size_t(g.dims.y) + std::size_t(y);
    };
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        std::vector<float> along(slice);
        std::vector<std::uint8_t> any(std::size_t(g.dims.y));
        for (int y = 0; y < g.dims.y; ++y)
            any[std::size_t(y)] =
                distanceAlongRow(m.voxels.data() + rowIndex(y, z) * length, g.dims.x, float(g.spacing_m.x),
                                 along.data() + std::size_t(y) * length);
        const auto rows = [&](int y) -> const float* {
            return any[std::size_t(y)] ? along.data() + std::size_t(y) * length : nullptr;
        };
        for (int y = 0; y < g.dims.y; ++y)
            has_value[rowIndex(y, z)] =
                minimumOfRows(rows, y, g.dims.y, steps(1), float(g.spacing_m.y),
                              in_plane.voxels.data() + rowIndex(y, z) * length, g.dims.x);
    });
    Mask out(g);
    parallelFor(processorCount(), g.dims.y, [&](int y) {
        std::vector<float> nearest(length);
        const auto rows = [&](int z) -> const float* {
            return has_value[rowIndex(y, z)] ? in_plane.voxels.data() + rowIndex(y, z) * length : nullptr;
        };
        for (int z = 0; z < g.dims.z; ++z) {
            if (!minimumOfRows(rows, z, g.dims.z, steps(2), float(g.spacing_m.z), nearest.data(), g.dims.x))
                continue;
            std::uint8_t* const to = out.voxels.data() + rowIndex(y, z) * length;
            for (std::size_t x = 0; x < length; ++x)
                to[x] = nearest[x] <= reach2_m2;
        }
    });
    return out;
}

void dilate(Mask& m, double radius_m) {
    m = voxelsWithin(m, radius_m);
}

void erode(Mask& m, double radius_m) {
    const Mask lost = voxelsWithin(inverted(m), radius_m);
    m = subtract(std::move(m), lost);
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

// `combine` reads both values in every case, so that the compiler vectorises the loop.
template <typename Combine>
Mask combined(Mask a, const Mask& b, const Combine& combine) {
    std::uint8_t* const to = a.voxels.data();
    const std::uint8_t* const from = b.voxels.data();
    for (std::size_t i = 0, count = a.voxels.size(); i < count; ++i)
        to[i] = combine(to[i] != 0, from[i] != 0);
    return a;
}

}  // namespace

Mask intersect(Mask a, const Mask& b) {
    return combined(std::move(a), b, [](bool in_a, bool in_b) { return in_a & in_b; });
}

Mask subtract(Mask a, const Mask& b) {
    return combined(std::move(a), b, [](bool in_a, bool in_b) { return in_a & !in_b; });
}

Mask unite(Mask a, const Mask& b) {
    return combined(std::move(a), b, [](bool in_a, bool in_b) { return in_a | in_b; });
}

std::size_t countVoxels(const Mask& m) {
    return m.voxels.size() - std::size_t(std::count(m.voxels.begin(), m.voxels.end(), std::uint8_t{0}));
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
    const MaskRuns pieces(m, touch);
    const double each_ml = voxelVolume_ml(m.grid);
    m = pieces.where([&](std::size_t n) { return double(pieces.voxelCounts()[n]) * each_ml >= min_ml; });
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
    const auto forEachFree = [&](const Index3& from, const auto& visit) {
        forEachNeighbour(out.grid, from, Connectivity::faces, [&](std::size_t to) {
            if (!out.voxels[to] && passable.voxels[to]) visit(to);
        });
    };
    std::vector<std::size_t> front, next;
    forEachVoxel(out.grid, [&](const Index3& i) {
        bool grows = false;  // most seeds lie deep inside, and a front of all of them would be large
        if (out[i]) forEachFree(i, [&](std::size_t) { grows = true; });
        if (grows) front.push_back(out.grid.offset(i));
    });
    for (int step = 0; step < max_steps && !front.empty(); ++step) {
        next.clear();
        for (const std::size_t from : front)
            forEachFree(out.grid.voxelAt(from), [&](std::size_t to) {
                out.voxels[to] = out.voxels[from];
                next.push_back(to);
            });
        front.swap(next);
    }
    return out;
}

}  // namespace stylet::modeller
