// How far a segmentation is from the truth.
#pragma once

#include <limits>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct Agreement {
    double dice = 0.0;
    // Both ways between the surfaces; Hausdorff at the 95th percentile and at the worst.
    double mean_surface_m = 0.0, hausdorff95_m = 0.0, hausdorff_m = 0.0;
    double mean_surface_there_m = std::numeric_limits<double>::quiet_NaN();  // NaN where no surface is there
    double truth_ml = 0.0, found_ml = 0.0;
};

// All on one grid. Where truth or found is empty the distances are infinite. `places`: where a mean of its
// own is taken over the surfaces.
Agreement compare(const Mask& truth, const Mask& found, const Mask& places);
inline Agreement compare(const Mask& truth, const Mask& found) {
    return compare(truth, found, Mask(truth.grid));
}

}  // namespace stylet::modeller
