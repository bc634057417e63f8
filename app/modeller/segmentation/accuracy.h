// Measures the accuracy of a segmentation against the truth.
#pragma once

#include <limits>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct Agreement {
    double dice = 0.0;
    // Surface distances in both directions; Hausdorff distance at the 95th percentile and the maximum.
    double mean_surface_m = 0.0, hausdorff95_m = 0.0, hausdorff_m = 0.0;
    double mean_surface_near_m = std::numeric_limits<double>::quiet_NaN();  // within `region`; NaN if no
                                                                            // surface
    double truth_ml = 0.0, found_ml = 0.0;
};

// All masks are on one grid. Distances are infinite if truth or found is empty. `region` is the region in
// which `mean_surface_near_m` is measured.
Agreement compare(const Mask& truth, const Mask& found, const Mask& region);
inline Agreement compare(const Mask& truth, const Mask& found) {
    return compare(truth, found, Mask(truth.grid));
}

}  // namespace stylet::modeller
