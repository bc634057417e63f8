// Each node takes its own way back, in midpoint steps. Scaling and squaring (Arsigny et al. 2006) reads the
// large table over and over where this reads the model's small one, and adds an interpolation each time: it
// was slower and farther off (stylet-bench --only patient.breathing has both).
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
    // Half of the machine: the other loops go on.
    if (threads == 0) threads = std::max(2, int(std::thread::hardware_concurrency()) / 2);
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

// One part of the motion at this moment, and the level beside it. In single precision and the model's own
// voxels: a table needs no more.
class Field {
  public:
    Field(const MotionModel& model, MotionPart part, const Surrogate& now, int steps)
        : grid_(model.grid), steps_(steps), nodes_(model.grid.voxelCount()) {
        Index3 i;
        for (i.z = 0; i.z < grid_.dims.z; ++i.z)
            for (i.y = 0; i.y < grid_.dims.y; ++i.y)
                for (i.x = 0; i.x < grid_.dims.x; ++i.x) {
                    const std::size_t at = grid_.offset(i);
                    const Vec3 w = patient::motionField_m(model, part, now, grid_.centre(i));
                    nodes_[at] =
                        glm::vec4(glm::vec3(-w / (grid_.spacing_m * double(steps))), model.level_m[at]);
                }
    }

    glm::vec3 voxelsOf(const Vec3& p) const { return glm::vec3(grid_.toVoxels(p)); }
    glm::vec3 metresOf(const glm::vec3& voxels) const { return voxels * glm::vec3(grid_.spacing_m); }

    // xyz: what one step moves by, w: level; the border's beyond it.
    glm::vec4 at(const glm::vec3& voxels) const {
        const glm::vec3 inner = glm::clamp(voxels, glm::vec3(0.0f), glm::vec3(grid_.dims - 1));
        const Index3 low = glm::min(Index3(inner), grid_.dims - 2);
        const glm::vec3 f = inner - glm::vec3(low);
        const std::size_t row = std::size_t(grid_.dims.x), slice = row * std::size_t(grid_.dims.y);
        const glm::vec4* const n = nodes_.data() + grid_.offset(low);
        const glm::vec4* const m = n + slice;
        return glm::mix(glm::mix(glm::mix(n[0], n[1], f.x), glm::mix(n[row], n[row + 1], f.x), f.y),
                        glm::mix(glm::mix(m[0], m[1], f.x), glm::mix(m[row], m[row + 1], f.x), f.y), f.z);
    }

    // exp(-w) of a point, in voxels; `first`: what at() is there.
    glm::vec3 back(glm::vec3 voxels, glm::vec4 first) const {
        for (int i = 0; i < steps_; ++i) {
            if (i > 0) first = at(voxels);
            if (glm::vec3(first) == glm::vec3(0.0f)) break;
            voxels += glm::vec3(at(voxels + 0.5f * glm::vec3(first)));
        }
        return voxels;
    }

  private:
    Grid grid_;
    int steps_;
    std::vector<glm::vec4> nodes_;
};

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
    const Field wall(model, MotionPart::wall, now, settings.steps);
    const Field slide(model, MotionPart::slide, now, settings.steps);
    tables.inside.resize(grid.voxelCount()), tables.outside.resize(grid.voxelCount());
    // From here outward no cell reaches the inside.
    const float far_m = float(2.0 * glm::length(grid.spacing_m));
    forEachNode(grid, settings.threads, [&](const Index3& i, std::size_t at) {
        const glm::vec3 p = wall.voxelsOf(grid.centre(i));
        const glm::vec3 before = wall.back(p, wall.at(p));
        const glm::vec4 there = slide.at(before);
        const glm::vec3 inside = there.w > far_m ? before : slide.back(before, there);
        tables.outside[at] = glm::vec4(wall.metresOf(before - p), 0.0f);
        tables.inside[at] = glm::vec4(wall.metresOf(inside - p), there.w);
    });
    return tables;
}

Vec3 referenceFromTables(const DeformTables& tables, const Vec3& deformed_m) {
    const glm::vec4 inside = tableAt(tables.grid, tables.inside, deformed_m);
    if (inside.w < 0.0f) return deformed_m + Vec3(inside);
    return deformed_m + Vec3(tableAt(tables.grid, tables.outside, deformed_m));
}

}  // namespace stylet::render
