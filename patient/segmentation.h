// How much of a patient somebody has segmented. The paper compares forces over a full segmentation, in which
// every tissue has its label, with those over a partial one: the structures that a puncture is about, and
// thresholds elsewhere (Mastmeyer et al. 2017, "Virtual Patient Modeling using Partially Segmented CT data").
#pragma once

#include "patient/package.h"

namespace stylet::patient {

// Of the partial one: what the force table has as fascia, liver, vessel or duct.
bool isInPartialSegmentation(const Label&);

// Of what is soft tissue or denser by its CT value, the share that has a label. From every fourth voxel along
// each axis.
double segmentedShare(const Package&);
// So much of it that the forces over it are the truth the partial one is measured by. A table under the
// patient, and the scanner's noise, stay without a label.
inline constexpr double kFullShare = 0.9;
inline bool isFullySegmented(const Package& package) {
    return segmentedShare(package) >= kFullShare;
}

}  // namespace stylet::patient
