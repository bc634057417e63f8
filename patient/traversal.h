// Every voxel a segment passes through, in order, with its share of the way.
// Based on Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987.
#pragma once

#include <limits>

#include "patient/geometry.h"

namespace stylet::patient {

// Walks the cells of `grid` (a voxel's cell is centred on its centre) from a to b; cells beyond the grid are visited too.
//   for (VoxelWalk walk(grid, a, b); !walk.done(); walk.next()) use(walk.voxel(), walk.begin(), walk.end());
// begin() and end() are fractions of the way in [0, 1]; a zero-length segment visits its one voxel with begin = 0, end = 1.
class VoxelWalk {
  public:
    VoxelWalk(const Grid& grid, const Vec3& a, const Vec3& b) noexcept;
    bool done() const noexcept { return done_; }
    void next() noexcept;
    const Index3& voxel() const noexcept { return voxel_; }
    double begin() const noexcept { return begin_; }
    double end() const noexcept { return end_; }

  private:
    void findExit() noexcept;
    Index3 voxel_{0}, last_{0}, step_{0};
    Vec3 next_crossing_{0}, per_cell_{0};
    double begin_ = 0.0, end_ = 1.0;
    int axis_ = -1;
    bool done_ = false;
};

}  // namespace stylet::patient
