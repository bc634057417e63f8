// Internal: volumes that planning computes once per patient, before it looks at single paths.
#pragma once

#include <vector>

#include "patient/planning/planning.h"

namespace stylet::patient {

// distance beyond the target within which the duct's far wall is searched
inline constexpr double kBeyondTarget_m = 0.020;

// The largest uncertainty of a border that counts on the last stretch before the duct's wall
// (PlanSettings::near_target_m): vessels accompany the duct.
inline constexpr double kNearUncertainty_m = 0.002;

// The right flank at the height of the liver in the deformed patient, with a margin for clearances.
struct PlanRegion {
    // Distance from a voxel's border to the border of the nearest risk structure. Distances upward to a rib's
    // lower edge count half.
    Volume<float> clearance_m;
    // Where the border of an uncertain risk structure may lie (Label::border_uncertainty_m): 2 within
    // kNearUncertainty_m of the label, otherwise 1. No voxels if all borders are exact.
    Volume<std::uint8_t> uncertain;
    // 1 between two ribs: bone is near above and below. No voxels if the flank has no ribs.
    Volume<std::uint8_t> intercostal;
    std::vector<Vec3> entries_m;  // deformed positions of skin voxels, row by row from the feet to the head
    double back_m = 0.0;          // y of the back of the body, which is the top of the table
};

// Centre line of the ducts inside the liver, in the reference: duct voxels at a local maximum of the
// distance to the wall, thickest first. Voxels closer than `spacing_m` to a better one are left out; 0
// keeps all.
std::vector<Vec3> ductCentreLine(const Patient&, double spacing_m);

// Returns an empty region for a patient without a liver.
PlanRegion makePlanRegion(const Patient&, const PlanSettings&);

}  // namespace stylet::patient
