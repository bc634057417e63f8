// How completely a patient is segmented. The paper compares forces over a full and a partial segmentation. In
// the full one every tissue has a label. In the partial one only the structures relevant for the puncture
// have labels, and thresholds decide elsewhere (Mastmeyer et al. 2017, "Virtual Patient Modeling using
// Partially Segmented CT data").
#pragma once

#include "patient/package/package.h"

namespace stylet::patient {

// True for labels kept in the partial segmentation: fascia, liver, vessel and duct.
bool isInPartialSegmentation(const Label&);

// Share of labelled voxels among voxels whose CT value is that of soft tissue or denser. Samples every
// fourth voxel along each axis.
double segmentedShare(const Package&);
// A segmentation counts as full if at least this share is labelled. It can then serve as ground truth for the
// partial one. A table under the patient and scanner noise stay unlabelled.
inline constexpr double kFullShare = 0.9;
inline bool isFullySegmented(const Package& package) {
    return segmentedShare(package) >= kFullShare;
}

}  // namespace stylet::patient
