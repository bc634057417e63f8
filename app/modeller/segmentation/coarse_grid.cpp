#include "app/modeller/segmentation/coarse_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"

namespace stylet::modeller {

Grid coarseGrid(const Grid& fine, double spacing_m) {
    Grid g;
    for (int d = 0; d < 3; ++d) {
        const double extent = fine.dims[d] * fine.spacing_m[d];
        g.dims[d] = std::max(1, int(std::lround(extent / spacing_m)));
        g.spacing_m[d] = spacing_m;
        g.origin_m[d] = fine.origin_m[d] + 0.5 * (extent - fine.spacing_m[d] - (g.dims[d] - 1) * spacing_m);
    }
    return g;
}

FloatVolume coarseMean(const Grid& coarse, const Grid& fine, const std::function<float(std::size_t)>& value) {
    // For each axis, the coarse index of each fine index.
    std::array<std::vector<int>, 3> to;
    for (int d = 0; d < 3; ++d)
        for (int i = 0; i < fine.dims[d]; ++i) {
            const double at =
                (fine.origin_m[d] + i * fine.spacing_m[d] - coarse.origin_m[d]) / coarse.spacing_m[d];
            to[std::size_t(d)].push_back(std::clamp(int(std::floor(at + 0.5)), 0, coarse.dims[d] - 1));
        }
    FloatVolume mean(coarse);
    parallelFor(processorCount(), coarse.dims.z, [&](int slab) {
        std::vector<float> count(std::size_t(coarse.dims.x) * std::size_t(coarse.dims.y), 0.0f);
        float* sum = mean.voxels.data() + coarse.offset({0, 0, slab});
        for (int z = 0; z < fine.dims.z; ++z) {
            if (to[2][std::size_t(z)] != slab) continue;
            for (int y = 0; y < fine.dims.y; ++y)
                for (int x = 0; x < fine.dims.x; ++x) {
                    const std::size_t o = coarse.offset({to[0][std::size_t(x)], to[1][std::size_t(y)], 0});
                    sum[o] += value(fine.offset({x, y, z}));
                    count[o] += 1.0f;
                }
        }
        for (int y = 0; y < coarse.dims.y; ++y)
            for (int x = 0; x < coarse.dims.x; ++x) {
                const std::size_t o = coarse.offset({x, y, 0});
                const Index3 nearest = fine.nearest(coarse.centre({x, y, slab}));
                sum[o] = count[o] > 0.0f ? sum[o] / count[o]
                                         : value(fine.offset(glm::clamp(nearest, Index3(0), fine.dims - 1)));
            }
    });
    return mean;
}

}  // namespace stylet::modeller
