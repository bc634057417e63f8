#include "patient/synth/duct_branches.h"

#include <gtest/gtest.h>

#include "patient/synth/canvas.h"

namespace stylet::patient::synth {
namespace {

// Paints strokes into a 1 mm grid of 80 mm and returns their voxels.
std::vector<std::size_t> painted(LabelVolume& labels, const std::vector<Stroke>& strokes) {
    Grid grid;
    grid.dims = Index3(80);
    grid.spacing_m = Vec3(0.001);
    Canvas canvas(grid, Vec3(1.0), 1);
    paintStrokes(canvas, strokes, only(Id::air), Id::ducts);
    labels = canvas.labels;
    std::vector<std::size_t> voxels;
    for (std::size_t n = 0; n < labels.voxels.size(); ++n)
        if (labels.voxels[n] == std::uint8_t(Id::ducts)) voxels.push_back(n);
    return voxels;
}

TEST(DuctBranches, TubeIsOneBranchWithItsDiameter) {
    LabelVolume labels;
    const auto voxels = painted(labels, {{{40, 40, 10}, {40, 40, 70}, 2.5, 2.5}});
    // Branches start at the tube's widest place, which may lie anywhere. There are at most two, one in each
    // direction.
    const std::vector<Branch> branches = tubeBranches(labels, voxels);
    ASSERT_GE(branches.size(), 1u);
    ASSERT_LE(branches.size(), 2u);
    for (const Branch& b : branches)
        EXPECT_NEAR(b.diameter_mm, 5.0, 0.5);
}

TEST(DuctBranches, ForkHasThreeBranches) {
    LabelVolume labels;
    const Vec3 fork{40, 40, 40};
    const auto voxels = painted(
        labels,
        {{{40, 40, 8}, fork, 4.5, 3.6}, {fork, {15, 40, 70}, 2.0, 2.0}, {fork, {65, 40, 70}, 2.6, 2.6}});
    std::vector<Branch> branches = tubeBranches(labels, voxels);
    ASSERT_EQ(branches.size(), 3u);
    std::sort(branches.begin(), branches.end(),
              [](const Branch& a, const Branch& b) { return a.diameter_mm < b.diameter_mm; });
    EXPECT_NEAR(branches[0].diameter_mm, 4.0, 0.6);
    EXPECT_NEAR(branches[1].diameter_mm, 5.2, 0.6);
    EXPECT_NEAR(branches[2].diameter_mm, 8.0, 1.2);
}

TEST(DuctBranches, DepthReadsTheRadiusInTheMiddle) {
    LabelVolume labels;
    const auto voxels = painted(labels, {{{40, 40, 10}, {40, 40, 70}, 3.5, 3.5}});
    const std::vector<double> depth = depthInside(labels, voxels, 9.0);
    EXPECT_NEAR(*std::max_element(depth.begin(), depth.end()), 3.5, 0.5);
    EXPECT_DOUBLE_EQ(*std::min_element(depth.begin(), depth.end()), 0.5);
}

}  // namespace
}  // namespace stylet::patient::synth
