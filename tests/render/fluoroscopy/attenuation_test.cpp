#include "render/fluoroscopy/attenuation.h"

#include <gtest/gtest.h>

#include <glm/gtc/packing.hpp>

namespace stylet::render {
namespace {

double attenuationAt(const AttenuationVolume& v, std::size_t i) {
    return double(glm::unpackHalf1x16(v.half[i]));
}

CtVolume noisyCt(const Index3& dims, const Vec3& spacing_m) {
    CtVolume ct({dims, spacing_m, Vec3(0.01, -0.02, 0.03)}, std::int16_t(0));
    std::uint32_t bits = 1;
    for (std::int16_t& hu : ct.voxels) {
        bits = bits * 1664525u + 1013904223u;
        hu = std::int16_t(int(bits >> 20) % 1200 - 900);
    }
    return ct;
}

TEST(Attenuation, IsRelativeToWater) {
    EXPECT_EQ(relativeAttenuation(0.0), 1.0);
    EXPECT_EQ(relativeAttenuation(1000.0), 2.0);
    EXPECT_EQ(relativeAttenuation(-1000.0), 0.0);
    EXPECT_EQ(relativeAttenuation(-971.0), 0.0);
    EXPECT_NEAR(relativeAttenuation(-800.0), 0.2, 1e-12);
}

TEST(Attenuation, KeepsVoxelsThatAreLargerThanRequested) {
    const CtVolume ct = noisyCt({9, 7, 5}, Vec3(0.002));
    const AttenuationVolume v = computeAttenuation(ct, 0.001, 2);
    EXPECT_EQ(v.grid, ct.grid);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        ASSERT_NEAR(attenuationAt(v, i), relativeAttenuation(ct.voxels[i]), 1e-3);
}

// At any resampling ratio, the box and its total attenuation stay the same.
TEST(Attenuation, ResamplingPreservesTheTotal) {
    const CtVolume ct = noisyCt({41, 37, 30}, {0.0007, 0.0009, 0.0016});
    double whole = 0.0;
    for (const std::int16_t hu : ct.voxels)
        whole += relativeAttenuation(hu);
    whole *= ct.grid.spacing_m.x * ct.grid.spacing_m.y * ct.grid.spacing_m.z;
    for (const double voxel_m : {0.001, 0.0017, 0.0031, 1.0}) {
        const AttenuationVolume v = computeAttenuation(ct, voxel_m, 3);
        double sum = 0.0;
        for (std::size_t i = 0; i < v.half.size(); ++i)
            sum += attenuationAt(v, i);
        EXPECT_NEAR(sum * v.grid.spacing_m.x * v.grid.spacing_m.y * v.grid.spacing_m.z, whole, 5e-4 * whole);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(v.grid.dims[axis] * v.grid.spacing_m[axis],
                        ct.grid.dims[axis] * ct.grid.spacing_m[axis], 1e-12);
            EXPECT_NEAR(v.grid.origin_m[axis] - 0.5 * v.grid.spacing_m[axis],
                        ct.grid.origin_m[axis] - 0.5 * ct.grid.spacing_m[axis], 1e-12);
        }
    }
}

TEST(Cells, AreOccupiedAsFarAsTheMarginReaches) {
    CtVolume ct({Index3(80), Vec3(0.001), Vec3(0.0)}, std::int16_t(-1000));
    ct[{40, 41, 42}] = 0;
    const AttenuationVolume v = computeAttenuation(ct, 0.001, 1);
    for (const double margin_m : {0.0, 0.010}) {
        const CellGrid cells = makeCellGrid(v, 0.008, margin_m);
        EXPECT_EQ(cells.grid.dims, Index3(10));
        std::size_t occupied = 0;
        for (std::size_t n = 0; n < cells.occupied.size(); ++n) {
            const Index3 i(int(n) % 10, int(n) / 10 % 10, int(n) / 100);
            // Distance from the cell's box to the voxel, widened by interpolation.
            const Vec3 away = glm::max(
                glm::abs(cells.grid.centre(i) - Vec3(0.040, 0.041, 0.042)) - 0.004 - 0.001, Vec3(0.0));
            const bool near = std::max({away.x, away.y, away.z}) < margin_m;
            ASSERT_TRUE(!near || cells.occupied[n]) << i.x << " " << i.y << " " << i.z;
            occupied += cells.occupied[n];
        }
        EXPECT_GT(occupied, 0u);
        EXPECT_LT(occupied, margin_m == 0.0 ? 28u : 344u);
    }
}

}  // namespace
}  // namespace stylet::render
