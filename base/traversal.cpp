#include "base/traversal.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace stylet {
namespace {

constexpr double kMaxVoxelIndex = 1e9;  // fits an int, as do differences of two
constexpr std::int64_t kMaxWalkSteps = 1 << 16;

bool isRepresentable(const Vec3& v) noexcept {
    // NaN fails every comparison.
    return std::abs(v.x) < kMaxVoxelIndex && std::abs(v.y) < kMaxVoxelIndex && std::abs(v.z) < kMaxVoxelIndex;
}

Index3 cellContaining(const Vec3& v) noexcept {
    return {int(std::floor(v.x)), int(std::floor(v.y)), int(std::floor(v.z))};
}

}  // namespace

VoxelWalk::VoxelWalk(const Grid& grid, const Vec3& a, const Vec3& b) noexcept {
    // The same expression as Grid::nearest(), so that the ends agree with it to the last bit.
    start_ = grid.toVoxels(a) + 0.5;
    const Vec3 stop = grid.toVoxels(b) + 0.5;
    direction_ = stop - start_;
    voxel_ = isRepresentable(stop) ? cellContaining(stop) : Index3(-1);
    if (!isRepresentable(start_) || !isRepresentable(stop)) return;

    const Index3 first = cellContaining(start_), last = voxel_;
    std::int64_t steps = 0;
    for (int axis = 0; axis < 3; ++axis)
        steps += std::abs(std::int64_t(last[axis]) - first[axis]);
    if (steps > kMaxWalkSteps) return;

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
    return std::min((border - start_[axis]) / direction_[axis], 1.0);
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

namespace {

using Two = double __attribute__((vector_size(2 * sizeof(double))));

// The borders that a path crosses along one axis, in voxels.
struct AxisBorders {
    double first = 0.0, step = 0.0;  // the first border, and the distance to the next
    std::size_t count = 0;
    double start = 0.0, direction = 0.0;  // of the path along this axis
};

// VoxelWalk::crossing() for all borders of one axis, two at a time. Appends `end` as terminator.
void findCrossings(const AxisBorders& borders, double end, std::vector<double>& crossings) {
    const auto [border, step, count, start, direction] = borders;
    crossings.resize(count + 2);
    double* out = crossings.data();
    Two at = {border, border + step};
    for (std::size_t i = 0; i < count; i += 2, at += 2.0 * step) {
        const Two share = (at - start) / direction;
        out[i] = std::min(share[0], 1.0);
        out[i + 1] = std::min(share[1], 1.0);
    }
    out[count] = end;
}

// Merges the crossings of the three axes. Branch-free, because the next axis cannot be predicted. Steps from
// border to border of the axis with the most crossings, the main axis. Between two of its borders each of the
// other axes rarely has more than one crossing. Returns false if one has more and the pairs written below do
// not have the right order; the output is then invalid.
template <int kMain>
bool mergeCrossings(const std::vector<double> (&crossings)[3], const std::int64_t (&step)[3],
                    std::int64_t offset, VoxelPath::Visit* out) {
    constexpr int kA = kMain == 0 ? 1 : 0, kB = kMain == 2 ? 1 : 2;
    const double *a = crossings[kA].data(), *b = crossings[kB].data();
    const std::int64_t by_a = step[kA], by_b = step[kB];
    // On a tie the lower axis comes first.
    const auto aIsDue = [&](double until) { return kA < kMain ? *a <= until : *a < until; };
    const auto bIsDue = [&](double until) { return kB < kMain ? *b <= until : *b < until; };
    *out++ = {offset, 0.0};
    bool ordered = true;
    for (const double until : crossings[kMain]) {
        while (true) {
            const double at_a = *a, at_b = *b;
            const std::int64_t a_due = aIsDue(until), b_due = bIsDue(until), a_first = at_a <= at_b;
            out[0] = {offset + by_b + ((by_a - by_b) & -a_first), std::min(at_a, at_b)};
            out[1] = {offset + by_a + by_b, std::max(at_a, at_b)};
            out += a_due + b_due;
            offset += (by_a & -a_due) + (by_b & -b_due);
            a += a_due, b += b_due;
            if (!aIsDue(until) && !bIsDue(until)) break;
            ordered = ordered && out[-1].begin < std::min(*a, *b);
        }
        offset += step[kMain];
        *out++ = {offset, until};
    }
    return ordered;
}

}  // namespace

const std::vector<VoxelPath::Visit>& VoxelPath::traverse(const Grid& grid, const Vec3& a, const Vec3& b) {
    const VoxelWalk walk(grid, a, b);
    const Index3 count = walk.left_, first = walk.voxel_;
    const int main = count.x >= count.y ? (count.x >= count.z ? 0 : 2) : (count.y >= count.z ? 1 : 2);
    const std::int64_t row = grid.dims.x, slab = row * grid.dims.y;
    const std::int64_t step[3] = {walk.step_.x, walk.step_.y * row, walk.step_.z * slab};
    for (int axis = 0; axis < 3; ++axis) {
        const double border = first[axis] + (walk.step_[axis] > 0 ? 1.0 : 0.0);
        // Each list ends with a value above every crossing. The main axis has the smaller one, so the loop
        // over it ends after all crossings of the other axes.
        findCrossings({.first = border,
                       .step = double(walk.step_[axis]),
                       .count = std::size_t(count[axis]),
                       .start = walk.start_[axis],
                       .direction = walk.direction_[axis]},
                      axis == main ? 2.0 : 3.0, crossings_[axis]);
        if (axis == main) crossings_[axis].resize(std::size_t(count[axis]) + 1);
    }

    const std::size_t steps = std::size_t(count.x) + std::size_t(count.y) + std::size_t(count.z);
    visits_.resize(steps + 4);  // mergeCrossings() writes ahead of its result
    const std::int64_t offset = first.z * slab + first.y * row + first.x;
    const bool ordered = (main == 0   ? mergeCrossings<0>
                          : main == 1 ? mergeCrossings<1>
                                      : mergeCrossings<2>)(crossings_, step, offset, visits_.data());
    visits_.resize(steps + 1);
    if (!ordered) {
        std::size_t i = 0;
        for (VoxelWalk w = walk; !w.done(); w.next(), ++i)
            visits_[i] = {w.voxel().z * slab + w.voxel().y * row + w.voxel().x, w.begin()};
    }
    for (std::size_t i = 1; i <= steps && visits_[i].begin < 0.0; ++i)  // below 0 by a rounding error
        visits_[i].begin = 0.0;
    // A path with both ends inside the grid stays inside.
    if (!grid.contains(first) || !grid.contains(first + count * walk.step_)) {
        std::size_t i = 0;
        for (VoxelWalk w = walk; !w.done(); w.next(), ++i)
            if (!grid.contains(w.voxel())) visits_[i].offset = kOutside;
    }
    return visits_;
}

}  // namespace stylet
