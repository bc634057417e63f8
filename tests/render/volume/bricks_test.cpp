#include "render/volume/bricks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "render/volume/classified.h"
#include "tests/render/phantoms.h"
#include "tests/render/pictures.h"

namespace stylet::render {
namespace {

TEST(Bricks, DistanceIsTheChebyshevDistance) {
    BrickGrid grid(Index3(13, 9, 11) * kBrickVoxels);
    std::mt19937 random(7);
    for (int i = 0; i < 6; ++i)
        grid.occupied[random() % grid.occupied.size()] = 1;
    const auto distance = leapDistances(grid);
    forEachVoxel({grid.dims}, [&](const Index3& here) {
        int nearest = 1000;
        forEachVoxel({grid.dims}, [&](const Index3& i) {
            const Index3 apart = glm::abs(i - here);
            if (grid.occupied[grid.offset(i.x, i.y, i.z)])
                nearest = std::min(nearest, std::max({apart.x, apart.y, apart.z}));
        });
        ASSERT_EQ(int(distance[grid.offset(here.x, here.y, here.z)]), nearest)
            << here.x << " " << here.y << " " << here.z;
    });
}

TEST(Bricks, VoxelOnABrickEdgeOccupiesBothBricks) {
    const Index3 voxels(32, 24, 24);
    BrickGrid grid(voxels);
    std::vector<std::byte> plane(std::size_t(voxels.x) * std::size_t(voxels.y) * 4, std::byte{0});
    plane[(12 * 32 + 16) * 4 + 3] = std::byte{9};  // x = 16: the first voxel of the third brick
    markOccupied(grid, voxels, 11, 12, plane.data());
    EXPECT_EQ(std::count(grid.occupied.begin(), grid.occupied.end(), 1), 2);
    EXPECT_EQ(grid.occupied[grid.offset(1, 1, 1)], 1);
    EXPECT_EQ(grid.occupied[grid.offset(2, 1, 1)], 1);
}

// During breathing, no visible point may lie in a brick that rays skip.
TEST(Bricks, NoVisiblePointIsSkippedDuringBreathing) {
    const patient::Package package = test::makeTrunk(0.002);
    const patient::Patient patient(package);
    const Palette palette = makePalette(loadLook(test::assetsFolder() / "looks" / "reveal.toml"), patient);
    const Index3 dims = package.ct.grid.dims;
    std::vector<std::byte> rgba(package.ct.grid.voxelCount() * 4);
    classifyPlanes(patient, palette, 0, dims.z, rgba.data(), 2);
    BrickGrid reference(dims);
    markOccupied(reference, dims, 0, dims.z, rgba.data());
    DeformTableBuilder maker(package.motion, {}, &patient);
    BreathingBricks bricks(reference);
    Workers workers(2);
    for (const double v : {0.3, 1.0}) {
        const patient::Surrogate breath{v, 0.0};
        maker.compute(breath, workers);
        bricks.update(package.ct.grid, maker.tables(), maker.reach_m(), workers);
        const BrickGrid& deformed = bricks.occupancy();
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(0.0, 1.0);
        int visible = 0;
        for (int i = 0; i < 200000; ++i) {
            const Vec3 in_voxels = Vec3(any(random), any(random), any(random)) * Vec3(dims) - 0.5;
            const Vec3 p = package.ct.grid.origin_m + package.ct.grid.spacing_m * in_voxels;
            const Vec3 source = package.ct.grid.toVoxels(referenceFromDeformed(package.motion, breath, p));
            const Index3 from = (Index3(glm::floor(source + 0.5))) / kBrickVoxels;
            if (!package.ct.grid.contains(Index3(glm::floor(source + 0.5)))) continue;
            const Index3 to = Index3(glm::floor(in_voxels + 0.5)) / kBrickVoxels;
            if (!reference.occupied[reference.offset(from.x, from.y, from.z)]) continue;
            ++visible;
            ASSERT_TRUE(deformed.occupied[deformed.offset(to.x, to.y, to.z)])
                << v << ": " << p.x << " " << p.y << " " << p.z;
        }
        EXPECT_GT(visible, 10000);
        const auto share = [](const BrickGrid& g) {
            return double(std::count(g.occupied.begin(), g.occupied.end(), 1)) / double(g.occupied.size());
        };
        EXPECT_LT(share(deformed), 1.0);
    }
}

}  // namespace
}  // namespace stylet::render
