// The phantom experiment of Fig. 16 in Mastmeyer et al. 2017: two fasciae, fully segmented and partially
// segmented, and the same needle insertion through both.
#pragma once

#include <vector>

#include "app/report/force_curves.h"
#include "app/trainer/attempt/scenario.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// Skin, soft tissue, fascia, soft tissue, fascia, liver from x = 0 inward. No breathing.
struct TwoFasciae {
    // Every tissue is labelled, as by an expert.
    patient::Package reference;
    // Only fasciae and liver are labelled; thresholds classify the rest. Behind the first fascia the mask is
    // one voxel too thick, which cannot be felt. In front of the second fascia some voxels are dark enough to
    // be classified as air. There, phase 1 starts from a different force, and the cut occurs late.
    patient::Package segmented;
    patient::PlannedPath path;
    double first_fascia_m = 0.0, second_fascia_m = 0.0;
};
TwoFasciae makeTwoFasciae(const patient::TissueTable&, const patient::Thresholds&);

// One simulated attempt: the force over depth during the advance, and the cuts of the fasciae.
struct FasciaRun {
    std::vector<report::DepthForce> way_in;
    std::vector<report::DepthForce> cuts;
};
FasciaRun playFasciae(const patient::Package&, const patient::PlannedPath&, const Scenario&);

// Largest force difference between two insertions within a depth range. They are compared at every depth of
// the first.
double largestDifference_n(const FasciaRun&, const FasciaRun&, double begin_m, double end_m);

report::Comparison compareFasciae(const TwoFasciae&, const FasciaRun& reference, const FasciaRun& segmented);

}  // namespace stylet::trainer
