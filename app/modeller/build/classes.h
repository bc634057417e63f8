// What the CT values of one patient mean: the classes of tissue as normal distributions, and the thresholds
// of the force model that follow from them.
#pragma once

#include <vector>

#include "app/modeller/voxel_tools.h"
#include "patient/tissue.h"

namespace stylet::modeller {

struct TissueClass {
    double mean_hu = 0.0, sigma_hu = 1.0;
    double share = 0.0;  // of the body's voxels
};

// Found without any label. `soft` and `bone` are those of the body's wall, where a needle meets them first;
// `blood` is what contrast medium fills, organs that it fills evenly among them; of share 0 in a scan
// without.
struct TissueClasses {
    TissueClass lung, fat, soft, blood, bone;
    double noise_hu = 1.0;  // of one voxel, within even tissue
};

TissueClasses classesOf(const patient::CtVolume&, const Mask& body);

// t0, t1, t2- and t2+ as model.md's section 10 has them.
patient::Thresholds thresholdsOf(const TissueClasses&);

}  // namespace stylet::modeller
