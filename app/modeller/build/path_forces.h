// What a segmentation's errors do to the forces on planned paths.
#pragma once

#include <vector>

#include "patient/patient.h"

namespace stylet::modeller {

struct PathForces {
    std::size_t paths = 0;
    double rms_n = 0.0;  // over all ticks with the needle in either patient
    double median_path_rms_n = 0.0, worst_path_rms_n = 0.0;
    double largest_n = 0.0;
    double equal_share = 0.0;  // of those ticks, to the last bit
};

// The needle goes down each path at a steady 20 mm/s in both patients, breath held where the path was
// planned. Ends lie in the reference, which both share.
PathForces compareForces(const patient::Patient& truth, const patient::Patient& found,
                         const std::vector<patient::PlannedPath>&);

}  // namespace stylet::modeller
