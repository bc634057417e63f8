// Visits every voxel that a segment passes through, in order. Each visit has the share of the path at which
// it begins.
// Based on Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987.
// Crossings are computed from integer borders, not by adding up steps. So rounding errors do not accumulate
// and the walk ends at the right voxel.
#pragma once

#include <cstdint>
#include <vector>

#include "base/geometry.h"

namespace stylet {

// Walks the cells of `grid` from a to b. A voxel's cell is centred on the voxel's centre. Cells outside
// the grid are visited too.
//   for (VoxelWalk walk(grid, a, b); !walk.done(); walk.next()) use(walk.voxel(), walk.begin(),
//   walk.end());
// The first voxel is grid.nearest(a), the last is grid.nearest(b). Each step crosses one face; an edge or
// corner is crossed face by face, with begin == end in between. begin() and end() are shares of the path in
// [0, 1]. A segment of zero length visits one voxel with begin = 0 and end = 1. If an end is not finite or
// the path has more than 2^16 voxels, the walk visits a single voxel: that of b, or one outside every grid if
// b has none. Any thread. noexcept, no allocation.
class VoxelWalk {
  public:
    VoxelWalk(const Grid& grid, const Vec3& a, const Vec3& b) noexcept;
    bool done() const noexcept { return done_; }
    void next() noexcept;
    const Index3& voxel() const noexcept { return voxel_; }
    double begin() const noexcept { return begin_; }
    double end() const noexcept { return end_; }

  private:
    friend class VoxelPath;
    double crossing(int axis) const noexcept;
    void findExit() noexcept;

    Vec3 start_{0.0}, direction_{0.0};  // in voxels, cell borders at integers
    Vec3 next_crossing_{2.0};           // share of the path; above 1 if no border is left
    Index3 voxel_{0}, step_{0}, left_{0};
    double begin_ = 0.0, end_ = 1.0;
    int axis_ = -1;
    bool done_ = false;
};

// The same walk as a list, for callers with millions of paths. Reuses its buffers.
class VoxelPath {
  public:
    static constexpr std::int64_t kOutside = -1;
    struct Visit {
        std::int64_t offset;  // of the voxel in the grid, or kOutside
        double begin;         // as VoxelWalk::begin()
    };
    // The visits from a to b, valid until the next call. Number, order and values are bit-equal to
    // VoxelWalk's.
    const std::vector<Visit>& traverse(const Grid& grid, const Vec3& a, const Vec3& b);

  private:
    std::vector<double> crossings_[3];  // along each axis, ascending, terminated by a value above 1
    std::vector<Visit> visits_;
};

}  // namespace stylet
