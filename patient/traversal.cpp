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

}  // namespace stylet::patient
