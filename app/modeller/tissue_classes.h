// What the CT values of one patient mean: classes of tissue as normal distributions, and the thresholds of
// the force model that follow from them (model.md, section 10).
#pragma once

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::modeller {

struct TissueClass {
    double mean_hu = 0.0, sigma_hu = 1.0;
    double share = 0.0;  // of the voxels among which it was looked for; 0: none
};

// `soft` is the muscle that a needle meets first; `blood` what contrast medium fills.
struct TissueClasses {
    TissueClass fat, soft, blood, bone;
};

// Without any label: soft tissue and bone are those of the body's wall, 35 mm deep; blood is what is bright,
// thick and even, organs that contrast medium fills evenly among it.
TissueClasses classesOf(const patient::CtVolume&, const Mask& body);
// With labels of targetTable(): bone and blood are theirs, fat and soft tissue what has none.
TissueClasses classesOf(const patient::CtVolume&, const Mask& body, const patient::LabelVolume&);

// t2_sensitive is where soft tissue and bone are equally likely, but clear of soft tissue's noise;
// t2_specific clear of the blood's, too.
patient::Thresholds thresholdsOf(const TissueClasses&);

}  // namespace stylet::modeller
