// How completely a patient is segmented. The paper compares forces over a full segmentation, where every
// tissue has a label, with forces over a partial one, where only the structures relevant for the puncture
// have labels and thresholds decide elsewhere (Mastmeyer et al. 2017, "Virtual Patient Modeling using
// Partially Segmented CT data").
#pragma once

#include "patient/package/package.h"

namespace stylet::patient {

// True for labels kept in the partial segmentation: fascia, liver, vessel and duct.
bool isInPartialSegmentation(const Label&);

// Share of labelled voxels among voxels whose CT value is that of soft tissue or denser. Samples every
// fourth voxel along each axis.
double segmentedShare(const Package&);
// From this share on a segmentation counts as full and can serve as ground truth for the partial one. A
// table under the patient and scanner noise stay unlabelled.
inline constexpr double kFullShare = 0.9;
inline bool isFullySegmented(const Package& package) {
    return segmentedShare(package) >= kFullShare;
}

}  // namespace stylet::patient
