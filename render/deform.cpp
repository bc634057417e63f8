// Based on Arsigny et al. 2006, "A Log-Euclidean Framework for Statistics on Diffeomorphisms".
#include "render/deform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>

namespace stylet::render {
namespace {

using patient::Grid;
using patient::Index3;
using patient::MotionModel;
using patient::MotionPart;
using patient::Surrogate;

using Table = std::vector<glm::vec4>;

// Linear between nodes; beyond them the nearest value, which is zero for a displacement.
glm::vec4 tableAt(const Grid& grid, const Table& table, const Vec3& p) {
    const glm::vec3 at(glm::clamp(grid.toVoxels(p), Vec3(0.0), Vec3(grid.dims - 1)));
    const Index3 low = glm::min(Index3(at), grid.dims - 2);
    const glm::vec3 f = at - glm::vec3(low);
    const glm::vec4* const n = table.data() + grid.offset(low);
    const std::size_t row = std::size_t(grid.dims.x), slice = row * std::size_t(grid.dims.y);
    const glm::vec4 near = glm::mix(glm::mix(n[0], n[1], f.x), glm::mix(n[row], n[row + 1], f.x), f.y);
    const glm::vec4* const m = n + slice;
    const glm::vec4 far = glm::mix(glm::mix(m[0], m[1], f.x), glm::mix(m[row], m[row + 1], f.x), f.y);
    return glm::mix(near, far, f.z);
}

template <typename Visit>
void forEachNode(const Grid& grid, int threads, const Visit& visit) {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t)
        workers.emplace_back([&, t] {
            Index3 i;
            for (i.z = t; i.z < grid.dims.z; i.z += threads)
                for (i.y = 0; i.y < grid.dims.y; ++i.y)
                    for (i.x = 0; i.x < grid.dims.x; ++i.x)
                        visit(i, grid.offset(i));
        });
}

// exp(-w) of one part: a midpoint step of 2^-squarings, then as many times itself after itself.
Table backward(const MotionModel& model, MotionPart part, const Surrogate& now, const Grid& grid,
               const DeformSettings& settings) {
    const double step = 1.0 / double(1 << settings.squarings);
    Table table(grid.voxelCount()), next(table.size());
    forEachNode(grid, settings.threads, [&](const Index3& i, std::size_t at) {
        const Vec3 p = grid.centre(i);
        const Vec3 here = patient::motionField_m(model, part, now, p);
        if (here == Vec3(0.0)) return;
        const Vec3 middle = patient::motionField_m(model, part, now, p - 0.5 * step * here);
        table[at] = glm::vec4(glm::vec3(-step * middle), 0.0f);
    });
    for (int k = 0; k < settings.squarings; ++k) {
        forEachNode(grid, settings.threads, [&](const Index3& i, std::size_t at) {
            const glm::vec4 own = table[at];
            const bool still = own == glm::vec4(0.0f);
            next[at] = still ? own : own + tableAt(grid, table, grid.centre(i) + Vec3(own));
        });
        table.swap(next);
    }
    return table;
}

// The motion's own box.
Grid tableGrid(const MotionModel& model, double spacing_m) {
    Grid grid;
    if (model.empty()) {
        grid.dims = Index3(2);
        grid.spacing_m = Vec3(1.0);
        grid.origin_m = Vec3(-0.5);
        return grid;
    }
    grid.origin_m = model.grid.origin_m;
    for (int axis = 0; axis < 3; ++axis) {
        const double extent_m = model.grid.spacing_m[axis] * (model.grid.dims[axis] - 1);
        const int cells = std::max(1, int(std::ceil(extent_m / spacing_m - 1e-9)));
        grid.dims[axis] = cells + 1;
        grid.spacing_m[axis] = extent_m / cells;
    }
    return grid;
}

}  // namespace

DeformTables deformTables(const MotionModel& model, const Surrogate& now, const DeformSettings& settings) {
    DeformTables tables;
    tables.grid = tableGrid(model, settings.spacing_m);
    const Grid& grid = tables.grid;
    if (model.empty()) {
        tables.inside.assign(grid.voxelCount(), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
        tables.outside.assign(grid.voxelCount(), glm::vec4(0.0f));
        return tables;
    }
    tables.outside = backward(model, MotionPart::wall, now, grid, settings);
    const Table slide = backward(model, MotionPart::slide, now, grid, settings);
    tables.inside.resize(grid.voxelCount());
    forEachNode(grid, settings.threads, [&](const Index3& i, std::size_t at) {
        const glm::vec4 wall = tables.outside[at];
        const Vec3 before = grid.centre(i) + Vec3(wall);
        const glm::vec4 whole = wall + tableAt(grid, slide, before);
        tables.inside[at] = glm::vec4(glm::vec3(whole), float(patient::cavityLevel_m(model, before)));
    });
    return tables;
}

Vec3 referenceFromTables(const DeformTables& tables, const Vec3& deformed_m) {
    const glm::vec4 inside = tableAt(tables.grid, tables.inside, deformed_m);
    if (inside.w < 0.0f) return deformed_m + Vec3(inside);
    return deformed_m + Vec3(tableAt(tables.grid, tables.outside, deformed_m));
}

}  // namespace stylet::render
