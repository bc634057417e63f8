#include "app/modeller/build/accuracy.h"

#include <algorithm>
#include <limits>

namespace stylet::modeller {

using patient::Grid;
using patient::Index3;

namespace {

// The mask's voxels with a face to what is not mask.
Mask surfaceOf(const Mask& mask) {
    const Grid& g = mask.grid;
    Mask surface(g);
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                if (!mask[i]) continue;
                for (const Index3 step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}})
                    for (const Index3& n : {i + step, i - step})
                        if (g.contains(n) && !mask[n]) surface[i] = 1;
            }
    });
    return surface;
}

void distancesFrom(const Mask& from, const Mask& to, std::vector<float>& out) {
    const FloatVolume distance = distanceTo(to);
    for (std::size_t i = 0; i < from.voxels.size(); ++i)
        if (from.voxels[i]) out.push_back(distance.voxels[i]);
}

}  // namespace

Agreement compare(const Mask& truth, const Mask& found) {
    std::size_t in_truth = 0, in_found = 0, in_both = 0;
    for (std::size_t i = 0; i < truth.voxels.size(); ++i) {
        in_truth += truth.voxels[i] != 0;
        in_found += found.voxels[i] != 0;
        in_both += truth.voxels[i] && found.voxels[i];
    }
    const auto& s = truth.grid.spacing_m;
    const double voxel_ml = 1e6 * s.x * s.y * s.z;
    Agreement a;
    a.truth_ml = double(in_truth) * voxel_ml;
    a.found_ml = double(in_found) * voxel_ml;
    if (in_truth == 0 || in_found == 0) {
        a.dice = in_truth == in_found ? 1.0 : 0.0;
        a.mean_surface_m = a.hausdorff95_m = a.hausdorff_m = std::numeric_limits<double>::infinity();
        return a;
    }
    a.dice = 2.0 * double(in_both) / double(in_truth + in_found);
    const Mask truth_surface = surfaceOf(truth), found_surface = surfaceOf(found);
    std::vector<float> distances;
    distancesFrom(truth_surface, found_surface, distances);
    distancesFrom(found_surface, truth_surface, distances);
    double sum = 0.0;
    for (const float d : distances)
        sum += double(d);
    a.mean_surface_m = sum / double(distances.size());
    const auto at95 = distances.begin() + std::ptrdiff_t(0.95 * double(distances.size() - 1));
    std::nth_element(distances.begin(), at95, distances.end());
    a.hausdorff95_m = double(*at95);
    a.hausdorff_m = double(*std::max_element(distances.begin(), distances.end()));
    return a;
}

}  // namespace stylet::modeller
