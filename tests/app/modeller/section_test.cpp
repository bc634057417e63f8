#include "app/modeller/import/section.h"

#include <gtest/gtest.h>

namespace stylet::modeller {
namespace {

// A CT that is linear in space keeps its values on any grid inside it.
TEST(Section, ResamplesLinearlyAndFillsTheOutside) {
    const auto hu = [](const Vec3& p) { return 1e4 * p.x - 2e4 * p.y + 3e4 * p.z; };
    for (const int slices : {1, 6}) {
        CtVolume ct(Grid{{8, 7, slices}, {0.001, 0.0015, 0.002}, {-0.003, 0.002, 0.001}});
        forEachVoxel(ct.grid,
                     [&](const Index3& i) { ct[i] = std::int16_t(std::lround(hu(ct.grid.centre(i)))); });
        const Grid to{{9, 9, slices == 1 ? 1 : 7}, {0.0009, 0.0011, 0.0013}, {-0.0041, 0.0025, 0.001}};
        const CtVolume out = resampleCt(ct, to);
        const Vec3 low = ct.grid.centre(Index3(0)), high = ct.grid.centre(ct.grid.dims - 1);
        forEachVoxel(to, [&](const Index3& i) {
            const Vec3 p = to.centre(i), beyond = glm::max(low - p, p - high) / ct.grid.spacing_m;
            if (std::max({beyond.x, beyond.y, beyond.z}) > 0.5)
                EXPECT_EQ(out[i], kOutside_hu);
            else  // half a voxel beyond the outermost centres, their value continues
                EXPECT_NEAR(out[i], hu(glm::clamp(p, low, high)), 1.0);
        });
    }
}

}  // namespace
}  // namespace stylet::modeller
