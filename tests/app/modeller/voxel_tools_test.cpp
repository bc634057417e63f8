#include "app/modeller/image/voxel_tools.h"

#include <gtest/gtest.h>

namespace stylet::modeller {
namespace {

Grid grid(int x, int y, int z) {
    return {{x, y, z}, {0.001, 0.0015, 0.002}, Vec3(0.0)};
}

TEST(VoxelTools, DistanceMatchesBruteForce) {
    std::uint32_t seed = 7;
    for (const Grid& g : {grid(13, 11, 9), grid(13, 1, 1), grid(1, 11, 1), grid(1, 1, 9)}) {
        Mask mask(g);
        for (int n = 0; n < 6; ++n) {
            seed = seed * 1664525u + 1013904223u;
            mask[{int(seed >> 8) % g.dims.x, int(seed >> 16) % g.dims.y, int(seed >> 24) % g.dims.z}] = 1;
        }
        // Solid blocks, at the border and inside.
        for (const VoxelBox& block : {VoxelBox{{0, 0, 0}, {3, 4, 2}}, VoxelBox{{7, 5, 4}, {10, 9, 7}}})
            forEachVoxel(block, [&](const Index3& i) {
                if (g.contains(i)) mask[i] = 1;
            });
        const FloatVolume d = distanceTo(mask);
        forEachVoxel(g, [&](const Index3& i) {
            double best = 1e9;
            forEachVoxel(g, [&](const Index3& s) {
                if (mask[s]) best = std::min(best, glm::length(g.centre(s) - g.centre(i)));
            });
            EXPECT_NEAR(d[i], best, 1e-6);
        });
    }
    EXPECT_GT(distanceTo(Mask(grid(3, 3, 3))).voxels[0], 100.0f);
}

TEST(VoxelTools, KeepsLargestComponentAndFloodFills) {
    Mask mask(grid(10, 4, 4));
    for (int x : {0, 1, 5, 6, 7})
        mask[{x, 2, 2}] = 1;
    mask[{8, 3, 2}] = 1;  // touches the larger component at an edge only
    Mask largest = mask;
    EXPECT_EQ(keepLargestComponent(largest), 3u);
    EXPECT_EQ((largest[{6, 2, 2}]), 1);
    EXPECT_EQ((largest[{8, 3, 2}]), 0);
    EXPECT_EQ((largest[{0, 2, 2}]), 0);
    Mask seed(mask.grid);
    seed[{1, 2, 2}] = 1;
    const Mask reached = floodFill(seed, mask);
    EXPECT_EQ((reached[{0, 2, 2}]), 1);
    EXPECT_EQ((reached[{5, 2, 2}]), 0);
    Mask beside(mask.grid);
    beside[{3, 2, 2}] = 1;
    EXPECT_TRUE(boundingBox(floodFill(beside, mask)).empty()) << "a seed that is not passable";
}

// Floods from each voxel that has no number yet.
LabelVolume floodedComponents(const Mask& mask, Connectivity touch, std::vector<std::size_t>& size) {
    LabelVolume number(mask.grid);
    size.assign(1, 0);
    for (std::size_t seed = 0; seed < mask.voxels.size(); ++seed) {
        if (!mask.voxels[seed] || number.voxels[seed]) continue;
        const auto component = std::uint8_t(size.size());
        std::vector<std::size_t> open{seed};
        number.voxels[seed] = component;
        size.push_back(0);
        while (!open.empty()) {
            const Index3 at = mask.grid.voxelAt(open.back());
            open.pop_back();
            ++size.back();
            forEachNeighbour(mask.grid, at, touch, [&](std::size_t to) {
                if (!mask.voxels[to] || number.voxels[to]) return;
                number.voxels[to] = component;
                open.push_back(to);
            });
        }
    }
    return number;
}

TEST(VoxelTools, ComponentsMatchFloods) {
    std::uint32_t random = 11;
    for (const Grid& g : {grid(19, 7, 6), grid(19, 7, 1), grid(1, 7, 6), grid(8, 1, 1)})
        for (const Connectivity touch : {Connectivity::faces, Connectivity::corners})
            for (const unsigned set_of_8 : {0u, 1u, 2u, 3u, 4u, 6u, 8u}) {
                Mask mask(g);
                for (std::uint8_t& voxel : mask.voxels) {
                    random = random * 1664525u + 1013904223u;
                    voxel = (random >> 24) % 8 < set_of_8;
                }
                std::vector<std::size_t> size;
                const LabelVolume flooded = floodedComponents(mask, touch, size);
                const Components found = findComponents(mask, touch);
                ASSERT_EQ(found.size, size) << set_of_8;
                for (std::size_t i = 0; i < flooded.voxels.size(); ++i)
                    ASSERT_EQ(found.number.voxels[i], flooded.voxels[i]) << set_of_8 << " at " << i;
            }
}

TEST(VoxelTools, HolesAreFilledPerSlice) {
    Mask mask(grid(7, 7, 3));
    forEachVoxel(VoxelBox{{1, 1, 0}, {5, 5, 2}},
                 [&](const Index3& i) { mask[i] = i.x == 1 || i.y == 1 || i.x == 5 || i.y == 5; });
    mask[{1, 3, 1}] = 0;  // slice 1 is open
    fillHolesPerSlice(mask);
    EXPECT_EQ((mask[{3, 3, 0}]), 1);
    EXPECT_EQ((mask[{3, 3, 1}]), 0);
    EXPECT_EQ((mask[{0, 0, 0}]), 0);
}

TEST(VoxelTools, BoxMeanMatchesBruteForce) {
    FloatVolume v(grid(6, 5, 4));
    for (std::size_t i = 0; i < v.voxels.size(); ++i)
        v.voxels[i] = float(i * i % 37);
    const FloatVolume mean = boxMean(v, 1);
    for (const Index3& at : {Index3{2, 2, 2}, Index3{0, 0, 0}, Index3{5, 2, 3}}) {
        double sum = 0.0, count = 0.0;
        forEachVoxel(VoxelBox{at - 1, at + 1}, [&](const Index3& i) {
            if (v.grid.contains(i)) sum += v[i], count += 1.0;
        });
        EXPECT_NEAR(mean[at], sum / count, 1e-4);
    }
}

}  // namespace
}  // namespace stylet::modeller
