// Internal: what planning knows of a patient before it looks at single paths.
#pragma once

#include <vector>

#include "patient/planning.h"

namespace stylet::patient {

inline constexpr double kBeyondTarget_m = 0.020;  // the far wall is looked for this far

// The right flank at the liver's height in the deformed patient, with room for clearances.
struct PlanRegion {
    // To the border of the nearest risk structure, from voxel to voxel; under a rib's lower edge half the
    // distance counts.
    Volume<float> clearance_m;
    // Where bone is near above and below: between two ribs. No voxels where the flank has no ribs.
    Volume<std::uint8_t> intercostal;
    std::vector<Vec3> entries_m;  // skin voxels, deformed; row by row from the feet to the head
    double back_m = 0.0;          // y of the body's back: the table's top
};

// Centre line of the ducts inside the liver, in the reference: the duct voxels farthest from its wall,
// thickest first. Each of them, or none nearer than `spacing_m` to a better one.
std::vector<Vec3> ductCentreLine(const Patient&, double spacing_m);

// Empty without a liver.
PlanRegion makePlanRegion(const Patient&, const PlanSettings&);

}  // namespace stylet::patient
