#include "base/geodesic.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::patient {
namespace {

// Sets label 1 where `in` returns true.
LabelVolume carved(const Index3& dims, double spacing_m, const auto& in) {
    LabelVolume labels(Grid{dims, Vec3(spacing_m), Vec3(0.01, 0.02, 0.03)});
    forEachVoxel(labels.grid, [&](const Index3& i) { labels[i] = in(i.x, i.y, i.z) ? 1 : 0; });
    return labels;
}

TEST(VoxelPiece, ContainsConnectedVoxelsUpToTheGridBorder) {
    const LabelVolume labels = carved({8, 5, 5}, 0.001, [](int x, int y, int z) {
        return (x == y && y == z) || (x == 7 && y == 0 && z == 0);  // a diagonal, and a separate voxel
    });
    const VoxelPiece piece = connectedPiece(labels, {2, 2, 2});
    ASSERT_EQ(piece.size(), 5u);
    for (std::size_t m = 0; m < piece.size(); ++m) {
        EXPECT_EQ(piece.voxel(m), Index3(int(m)));
        EXPECT_EQ(piece.at(piece.voxel(m)), std::int32_t(m));
        EXPECT_NEAR(glm::length(piece.centre(m) - labels.grid.centre(piece.voxel(m))), 0.0, 1e-12);
    }
    EXPECT_EQ(piece.at({7, 0, 0}), VoxelPiece::kNone);
    EXPECT_EQ(piece.at({100, -3, 2}), VoxelPiece::kNone);
    EXPECT_EQ(connectedPiece(labels, {-1, 0, 0}).size(), 0u);
    LabelSet ones{};
    ones[1] = true;
    EXPECT_EQ(connectedPiece(labels, {1, 0, 0}, ones).size(), 0u);
    EXPECT_EQ(connectedPieces(labels, ones).size(), 2u);
}

TEST(FloodFaces, ReachesVoxelsThroughFacesOnly) {
    const LabelVolume labels = carved({6, 6, 6}, 0.001, [](int x, int y, int z) {
        return (z == 2 && y == 3) || (x == 5 && y == 3) || (x == 0 && y == 4 && z == 3);  // the last: an edge
    });
    std::vector<bool> seen(labels.voxels.size());
    int reached = 0;
    floodFaces(labels.grid, {{0, 3, 2}}, [&](const Index3& i) {
        if (labels[i] == 0 || seen[labels.grid.offset(i)]) return false;
        seen[labels.grid.offset(i)] = true;
        ++reached;
        return true;
    });
    EXPECT_EQ(reached, 6 + 5);
}

TEST(Geodesic, IsExactAlongAxesAndDiagonalsAndFollowsCorners) {
    // An L shape: 10 voxels along x, then 6 along y.
    const LabelVolume labels = carved({12, 12, 3}, 0.002, [](int x, int y, int z) {
        return z == 1 && ((y == 2 && x >= 1 && x <= 10) || (x == 10 && y >= 2 && y <= 8));
    });
    const VoxelPiece piece = connectedPiece(labels, {1, 2, 1});
    const PathStart start{std::size_t(piece.at({1, 2, 1})), 0.001};
    const std::vector<double> distance_m = geodesic_m(piece, {&start, 1});
    EXPECT_NEAR(distance_m[std::size_t(piece.at({9, 2, 1}))], 0.001 + 8 * 0.002, 1e-12);
    EXPECT_NEAR(distance_m[std::size_t(piece.at({10, 8, 1}))], 0.001 + 13 * 0.002 + std::sqrt(2.0) * 0.002,
                1e-12);
    const std::vector<double> near = geodesic_m(piece, {&start, 1}, {}, 0.008);
    EXPECT_NEAR(near[std::size_t(piece.at({4, 2, 1}))], 0.007, 1e-12);
    EXPECT_EQ(near[std::size_t(piece.at({6, 2, 1}))], kUnreached_m);
}

TEST(Geodesic, IsAtMost13PercentLongerThanTheStraightLine) {
    const LabelVolume labels = carved({21, 21, 21}, 0.001, [](int, int, int) { return true; });
    const VoxelPiece piece = connectedPiece(labels, {10, 10, 10});
    const PathStart start{std::size_t(piece.at({10, 10, 10})), 0.0};
    const std::vector<double> distance_m = geodesic_m(piece, {&start, 1});
    for (std::size_t m = 0; m < piece.size(); ++m) {
        const double straight = glm::length(piece.centre(m) - piece.centre(start.member));
        EXPECT_GE(distance_m[m], straight * (1.0 - 1e-12));
        EXPECT_LE(distance_m[m], straight * 1.129 + 1e-12);
    }
}

TEST(Lumen, RadiusOfACylinderIsCorrect) {
    constexpr double kRadius = 5.0;
    const LabelVolume labels = carved({40, 16, 16}, 0.001, [](int, int y, int z) {
        return (y - 7.5) * (y - 7.5) + (z - 7.5) * (z - 7.5) < kRadius * kRadius;
    });
    const VoxelPiece piece = connectedPiece(labels, {20, 7, 7});
    const std::vector<double> wall = wallDistance_m(piece), radius = lumenRadius_m(piece, wall);
    for (std::size_t m = 0; m < piece.size(); ++m) {
        const Index3 i = piece.voxel(m);
        if (i.x < 8 || i.x > 31) continue;  // skip the ends, where the radius is smaller
        ASSERT_NEAR(radius[m], kRadius * 1e-3, 1.1e-3) << i.y << ' ' << i.z;
        EXPECT_LE(wall[m], radius[m]);
        EXPECT_GT(wall[m], 0.0);
    }
}

}  // namespace
}  // namespace stylet::patient
