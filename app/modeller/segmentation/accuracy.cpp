#include "app/modeller/segmentation/accuracy.h"

#include <algorithm>
#include <limits>

#include "base/statistics.h"

namespace stylet::modeller {

namespace {

// The mask's voxels that share a face with a voxel outside it.
Mask surfaceVoxels(const Mask& mask) {
    const Grid& g = mask.grid;
    Mask surface(g);
    parallelVoxels(g, [&](const Index3& i) {
        if (!mask[i]) return;
        for (const Index3 step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}})
            for (const Index3& n : {i + step, i - step})
                if (g.contains(n) && !mask[n]) surface[i] = 1;
    });
    return surface;
}

// Distances of surface voxels. Those in `region` are also summed separately.
struct Distances {
    std::vector<float> all_m;
    double sum_m = 0.0, sum_near_m = 0.0;
    std::size_t count_near = 0;

    void add(const Mask& from, const Mask& to, const Mask& region) {
        const FloatVolume distance = distanceTo(to);
        for (std::size_t i = 0; i < from.voxels.size(); ++i) {
            if (!from.voxels[i]) continue;
            all_m.push_back(distance.voxels[i]);
            sum_m += double(distance.voxels[i]);
            if (!region.voxels[i]) continue;
            sum_near_m += double(distance.voxels[i]);
            ++count_near;
        }
    }
};

}  // namespace

Agreement compare(const Mask& truth, const Mask& found, const Mask& region) {
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
    const Mask truth_surface = surfaceVoxels(truth), found_surface = surfaceVoxels(found);
    Distances d;
    d.add(truth_surface, found_surface, region);
    d.add(found_surface, truth_surface, region);
    if (d.all_m.empty()) return a;  // both masks fill the grid: no surface
    a.mean_surface_m = d.sum_m / double(d.all_m.size());
    if (d.count_near > 0) a.mean_surface_near_m = d.sum_near_m / double(d.count_near);
    a.hausdorff_m = double(*std::max_element(d.all_m.begin(), d.all_m.end()));
    a.hausdorff95_m = double(lowerQuantile(std::move(d.all_m), 0.95));
    return a;
}

}  // namespace stylet::modeller
