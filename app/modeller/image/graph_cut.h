// The minimum-cost separation of a volume into object and background.
// Based on Boykov and Jolly, "Interactive graph cuts", ICCV 2001, and Boykov and Kolmogorov, "An
// experimental comparison of min-cut/max-flow algorithms", IEEE TPAMI 26, 2004, as implemented in the Boost
// Graph Library.
#pragma once

#include <functional>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// State of a voxel before the cut. Only free voxels use memory: about 250 bytes each.
enum class CutState : std::uint8_t { background, object, free };

struct CutProblem {
    LabelVolume state;       // values of CutState
    FloatVolume preference;  // of a free voxel: positive prefers object, negative background
    // Cost of separating two voxels that share a face, given by their offsets. Symmetric, not negative.
    std::function<float(std::size_t, std::size_t)> link;
};

// Returns the object: the fixed object voxels and the free voxels on their side of the cheapest cut. Free
// voxels that are linked to neither side belong to the background. Costs are rounded to a thousandth, so the
// result is exact and the same on every machine.
Mask minimumCut(const CutProblem&);

}  // namespace stylet::modeller
