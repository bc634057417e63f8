#include "base/traversal.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

namespace stylet::patient {
namespace {

struct Visit {
    Index3 voxel;
    double begin, end;
};

std::vector<Visit> collectVisits(const Grid& grid, const Vec3& a, const Vec3& b) {
    std::vector<Visit> visits;
    for (VoxelWalk walk(grid, a, b); !walk.done(); walk.next())
        visits.push_back({walk.voxel(), walk.begin(), walk.end()});
    return visits;
}

Grid tenCube() {
    Grid grid;
    grid.dims = {10, 10, 10};
    grid.spacing_m = {0.001, 0.002, 0.0015};
    grid.origin_m = {-0.01, 0.02, 0.003};
    return grid;
}

void expectSoundWalk(const Grid& grid, const Vec3& a, const Vec3& b) {
    const std::vector<Visit> visits = collectVisits(grid, a, b);
    ASSERT_FALSE(visits.empty());
    EXPECT_EQ(visits.front().voxel, grid.nearest(a));
    EXPECT_EQ(visits.back().voxel, grid.nearest(b));
    EXPECT_EQ(visits.front().begin, 0.0);
    EXPECT_EQ(visits.back().end, 1.0);
    for (std::size_t i = 0; i < visits.size(); ++i) {
        EXPECT_LE(visits[i].begin, visits[i].end);
        // The midpoint of the visit lies in the visited cell, up to rounding.
        const Vec3 v =
            grid.toVoxels(a + 0.5 * (visits[i].begin + visits[i].end) * (b - a)) - Vec3(visits[i].voxel);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_LE(std::abs(v[axis]), 0.5 + 1e-6);
        if (i == 0) continue;
        EXPECT_EQ(visits[i].begin, visits[i - 1].end);
        const Index3 d = visits[i].voxel - visits[i - 1].voxel;
        EXPECT_EQ(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), 1);
    }

    VoxelPath path;
    const std::vector<VoxelPath::Visit>& whole = path.traverse(grid, a, b);
    ASSERT_EQ(whole.size(), visits.size());
    for (std::size_t i = 0; i < visits.size(); ++i) {
        EXPECT_EQ(whole[i].begin, visits[i].begin);
        EXPECT_EQ(whole[i].offset, grid.contains(visits[i].voxel) ? std::int64_t(grid.offset(visits[i].voxel))
                                                                  : VoxelPath::kOutside);
    }
}

TEST(VoxelWalk, RandomSegmentsInsideAndFarOutside) {
    std::mt19937 random(1);
    for (const double reach_m : {0.001, 0.02, 0.3}) {
        std::uniform_real_distribution<double> u(-reach_m, reach_m);
        for (int i = 0; i < 2000; ++i)
            expectSoundWalk(tenCube(), {u(random), u(random), u(random)}, {u(random), u(random), u(random)});
    }
}

// The first path crosses one minor axis twice before the other one, between two crossings of the main axis.
// The others are random.
TEST(VoxelWalk, NearTheDiagonal) {
    Grid grid;
    grid.dims = {8, 8, 8};
    grid.spacing_m = Vec3(1.0);
    expectSoundWalk(grid, {-0.1, -0.45, 0.0}, {2.6, 3.45, 0.9});
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(0.0, 8.0), near(-0.3, 0.3);
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 a(u(random), u(random), u(random));
        const Vec3 step = Vec3(4.0 * near(random)) + Vec3(near(random), near(random), near(random));
        expectSoundWalk(grid, a, a + step);
    }
}

TEST(VoxelWalk, AxisParallelBordersInClosedForm) {
    Grid grid;
    grid.dims = {8, 1, 1};
    grid.spacing_m = Vec3(0.25);
    const std::vector<Visit> visits = collectVisits(grid, {-0.125, 0, 0}, {0.875, 0, 0});
    ASSERT_EQ(visits.size(), 5u);  // the last cell begins at the end point
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(visits[std::size_t(i)].voxel, Index3(i, 0, 0));
        EXPECT_EQ(visits[std::size_t(i)].begin, 0.25 * i);
    }
    EXPECT_EQ(collectVisits(grid, {0.875, 0, 0}, {-0.125, 0, 0}).size(), 5u);
}

TEST(VoxelWalk, OnBordersEdgesAndCorners) {
    Grid grid;
    grid.dims = {8, 8, 8};
    grid.spacing_m = Vec3(1.0);
    for (const double a : {-1.5, 0.5, 2.5})
        for (const double b : {-0.5, 0.5, 3.5}) {
            expectSoundWalk(grid, Vec3(a), Vec3(b));
            expectSoundWalk(grid, {a, b, 0.5}, {b, a, 0.5});
            expectSoundWalk(grid, {0.5, a, 1.0}, {0.5, b, 1.0});
        }
}

TEST(VoxelWalk, ZeroLengthVisitsItsVoxel) {
    const Grid grid = tenCube();
    const Vec3 p = grid.centre({3, 4, 5});
    const std::vector<Visit> visits = collectVisits(grid, p, p);
    ASSERT_EQ(visits.size(), 1u);
    EXPECT_EQ(visits[0].voxel, Index3(3, 4, 5));
    EXPECT_EQ(visits[0].begin, 0.0);
    EXPECT_EQ(visits[0].end, 1.0);
}

TEST(VoxelWalk, ConsecutiveWalksShareTheirEndVoxel) {
    const Grid grid = tenCube();
    std::mt19937 random(2);
    std::uniform_real_distribution<double> u(-0.02, 0.04);
    Vec3 a{u(random), u(random), u(random)};
    for (int i = 0; i < 500; ++i) {
        const Vec3 b{u(random), u(random), u(random)}, c{u(random), u(random), u(random)};
        EXPECT_EQ(collectVisits(grid, a, b).back().voxel, collectVisits(grid, b, c).front().voxel);
        a = b;
    }
}

TEST(VoxelWalk, InvalidSegmentsAreASingleStep) {
    const Grid grid = tenCube();
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (const double bad : {inf, -inf, nan, 1e300, -1e300, 1e9}) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 p{0.0};
            p[axis] = bad;
            EXPECT_EQ(collectVisits(grid, Vec3(0.0), p).size(), 1u);
            EXPECT_EQ(collectVisits(grid, p, Vec3(0.0)).size(), 1u);
            EXPECT_EQ(collectVisits(grid, p, p).size(), 1u);
        }
    }
    EXPECT_FALSE(grid.contains(collectVisits(grid, Vec3(0.0), Vec3(nan))[0].voxel));
    EXPECT_EQ(collectVisits(grid, Vec3(0.0), {1e4, 0.0, 0.0}).size(), 1u);
}

}  // namespace
}  // namespace stylet::patient
