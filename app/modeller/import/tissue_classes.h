// The tissue classes of one patient's CT as normal distributions, and the force model's thresholds derived
// from them (model.md, section 10).
#pragma once

#include "app/modeller/image/voxel_tools.h"
#include "patient/tissue/tissue.h"

namespace stylet::modeller {

struct TissueClass {
    double mean_hu = 0.0, sigma_hu = 1.0;
    double share = 0.0;  // share of the voxels examined; 0: class not found
};

// `soft` is the muscle that a needle meets first. `blood` is anything filled with contrast medium.
struct TissueClasses {
    TissueClass fat, soft, blood, bone;
};

// Without labels: soft tissue and bone are measured in the body's outermost 35 mm. Blood is everything
// bright, thick and homogeneous, including organs that contrast medium fills evenly.
TissueClasses estimateTissueClasses(const CtVolume&, const Mask& body);
// With labels of targetTable(): bone and blood from their labels, fat and soft tissue from unlabelled
// voxels.
TissueClasses estimateTissueClasses(const CtVolume&, const Mask& body, const LabelVolume&);

// t2_sensitive is where soft tissue and bone are equally likely, but above the noise of soft tissue.
// t2_specific is also above the noise of blood.
patient::Thresholds computeThresholds(const TissueClasses&);

}  // namespace stylet::modeller
