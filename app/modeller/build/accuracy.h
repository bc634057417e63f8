// How far a segmentation is from the truth.
#pragma once

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

struct Agreement {
    double dice = 0.0;
    // Both ways between the surfaces; Hausdorff at the 95th percentile and at the worst.
    double mean_surface_m = 0.0, hausdorff95_m = 0.0, hausdorff_m = 0.0;
    double truth_ml = 0.0, found_ml = 0.0;
};

// Both on one grid. Where one of them is empty the distances are infinite.
Agreement compare(const Mask& truth, const Mask& found);

}  // namespace stylet::modeller
