#include "patient/traversal.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace stylet::patient {
namespace {

constexpr double kFarthestVoxel = 1e9;  // an int holds it, and differences of two
constexpr std::int64_t kMostSteps = 1 << 16;

bool countable(const Vec3& v) noexcept {
    // NaN fails every comparison.
    return std::abs(v.x) < kFarthestVoxel && std::abs(v.y) < kFarthestVoxel && std::abs(v.z) < kFarthestVoxel;
}

Index3 cellOf(const Vec3& v) noexcept {
    return {int(std::floor(v.x)), int(std::floor(v.y)), int(std::floor(v.z))};
}

}  // namespace

VoxelWalk::VoxelWalk(const Grid& grid, const Vec3& a, const Vec3& b) noexcept {
    // The same expression as Grid::nearest(), so that the ends agree with it to the last bit.
    start_ = grid.toVoxels(a) + 0.5;
    const Vec3 stop = grid.toVoxels(b) + 0.5;
    way_ = stop - start_;
    voxel_ = countable(stop) ? cellOf(stop) : Index3(-1);
    if (!countable(start_) || !countable(stop)) return;

    const Index3 first = cellOf(start_), last = voxel_;
    std::int64_t steps = 0;
    for (int axis = 0; axis < 3; ++axis)
        steps += std::abs(std::int64_t(last[axis]) - first[axis]);
    if (steps > kMostSteps) return;

    voxel_ = first;
    for (int axis = 0; axis < 3; ++axis) {
        left_[axis] = std::abs(last[axis] - first[axis]);
        step_[axis] = last[axis] < first[axis] ? -1 : 1;
        if (left_[axis] > 0) next_crossing_[axis] = crossing(axis);
    }
    findExit();
}

double VoxelWalk::crossing(int axis) const noexcept {
    const double border = voxel_[axis] + (step_[axis] > 0 ? 1.0 : 0.0);
    return std::min((border - start_[axis]) / way_[axis], 1.0);
}

void VoxelWalk::findExit() noexcept {
    axis_ = next_crossing_.x <= next_crossing_.y ? 0 : 1;
    if (next_crossing_.z < next_crossing_[axis_]) axis_ = 2;
    if (left_[axis_] == 0) axis_ = -1;
    end_ = axis_ < 0 ? 1.0 : std::max(begin_, next_crossing_[axis_]);
}

void VoxelWalk::next() noexcept {
    if (axis_ < 0) {
        done_ = true;
        return;
    }
    begin_ = end_;
    voxel_[axis_] += step_[axis_];
    next_crossing_[axis_] = --left_[axis_] > 0 ? crossing(axis_) : 2.0;
    findExit();
}

const std::vector<VoxelPath::Visit>& VoxelPath::along(const Grid& grid, const Vec3& a, const Vec3& b) {
    const VoxelWalk walk(grid, a, b);
    const Index3 count = walk.left_, step = walk.step_, first = walk.voxel_;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double>& crossings = crossings_[axis];
        crossings.resize(std::size_t(count[axis]) + 1);
        const double start = walk.start_[axis], way = walk.way_[axis];
        const double border = first[axis] + (step[axis] > 0 ? 1.0 : 0.0);
        for (int i = 0; i < count[axis]; ++i)
            crossings[std::size_t(i)] = std::min((border + double(i * step[axis]) - start) / way, 1.0);
        crossings.back() = 2.0;
    }

    const std::size_t steps = std::size_t(count.x) + std::size_t(count.y) + std::size_t(count.z);
    visits_.resize(steps + 1);
    const std::int64_t row = grid.dims.x, slab = row * grid.dims.y;
    const std::int64_t dx = step.x, dy = step.y * row, dz = step.z * slab;
    std::int64_t offset = first.z * slab + first.y * row + first.x;
    const double *x = crossings_[0].data(), *y = crossings_[1].data(), *z = crossings_[2].data();
    double begin = 0.0;
    visits_[0] = {offset, begin};
    // Without a branch: which face comes next cannot be predicted.
    for (std::size_t i = 1; i <= steps; ++i) {
        const double tx = *x, ty = *y, tz = *z;
        const bool x_first = tx <= ty, z_first = tz < (x_first ? tx : ty);
        const bool by_x = x_first & !z_first, by_y = !x_first & !z_first;
        const double at = z_first ? tz : x_first ? tx : ty;
        begin = std::max(begin, at);
        x += by_x;
        y += by_y;
        z += z_first;
        offset += z_first ? dz : by_x ? dx : dy;
        visits_[i] = {offset, begin};
    }
    // A path with both ends in the grid stays in it.
    if (!grid.contains(first) || !grid.contains(first + count * step)) {
        std::size_t i = 0;
        for (VoxelWalk w(grid, a, b); !w.done(); w.next(), ++i)
            if (!grid.contains(w.voxel())) visits_[i].offset = kOutside;
    }
    return visits_;
}

}  // namespace stylet::patient
