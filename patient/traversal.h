// Every voxel a segment passes through, in order, with its share of the way.
// Based on Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987;
// crossings are computed afresh from whole borders instead of summed, so that the walk ends where it should.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/geometry.h"

namespace stylet::patient {

// Walks the cells of `grid` (a voxel's cell is centred on its centre) from a to b; cells beyond the grid are
// visited too.
//   for (VoxelWalk walk(grid, a, b); !walk.done(); walk.next()) use(walk.voxel(), walk.begin(), walk.end());
// The first voxel is grid.nearest(a), the last grid.nearest(b), each step crosses one face (through an edge
// or corner: one face after the other, with begin == end between them). begin() and end() are fractions of
// the way in [0, 1]; a zero-length segment visits its one voxel with begin = 0, end = 1. An end that is not
// finite, and a way of more than 2^16 voxels, is one step: in the voxel of b, or outside every grid where b
// has none. Any thread. noexcept, no allocation.
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

    Vec3 start_{0.0}, way_{0.0};  // in voxels, cell borders at integers
    Vec3 next_crossing_{2.0};     // fraction of the way, beyond 1 where no border is left
    Index3 voxel_{0}, step_{0}, left_{0};
    double begin_ = 0.0, end_ = 1.0;
    int axis_ = -1;
    bool done_ = false;
};

// The same walk, whole: for callers with millions of paths. Keeps its buffers from path to path.
class VoxelPath {
  public:
    static constexpr std::int64_t kOutside = -1;
    struct Visit {
        std::int64_t offset;  // of the voxel in the grid, kOutside beyond it
        double begin;         // as VoxelWalk's
    };
    // The visits from a to b, until the next call: as many as VoxelWalk has, in its order, bit for bit.
    const std::vector<Visit>& along(const Grid& grid, const Vec3& a, const Vec3& b);

  private:
    std::vector<double> crossings_[3];  // of each axis, ascending, with an end beyond 1
    std::vector<Visit> visits_;
};

}  // namespace stylet::patient
