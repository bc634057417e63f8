// The phantom experiment of Fig. 16 in Mastmeyer et al. 2017: two fasciae, once fully segmented and once only
// in part, and one needle through either.
#pragma once

#include <vector>

#include "app/report/force_curves.h"
#include "app/trainer/scenario.h"
#include "patient/planning.h"

namespace stylet::trainer {

// Skin, soft tissue, fascia, soft tissue, fascia, liver from x = 0 inward; nothing breathes.
struct TwoFasciae {
    // All labels, as an expert would set them.
    patient::Package reference;
    // Fasciae and liver only; thresholds decide elsewhere. At the first fascia the mask is a voxel thicker,
    // which nobody feels. Before the second a group of voxels is dark enough to pass for air: phase 1 begins
    // from another force there, and the cut comes late.
    patient::Package segmented;
    patient::PlannedPath path;
    double first_fascia_m = 0.0, second_fascia_m = 0.0;
};
TwoFasciae makeTwoFasciae(const patient::TissueTable&, const patient::Thresholds&);

// One played attempt: the force over depth on the way in, and where fasciae were cut.
struct FasciaRun {
    std::vector<report::DepthForce> way_in;
    std::vector<report::DepthForce> cuts;
};
FasciaRun playFasciae(const patient::Package&, const patient::PlannedPath&, const Scenario&);

// The largest difference of two ways in over a stretch of depth, at every depth of the first.
double largestDifference_n(const FasciaRun&, const FasciaRun&, double begin_m, double end_m);

report::Comparison compareFasciae(const TwoFasciae&, const FasciaRun& reference, const FasciaRun& segmented);

}  // namespace stylet::trainer
