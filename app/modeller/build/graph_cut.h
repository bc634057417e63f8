// The cheapest separation of a volume into object and background.
// Based on Boykov and Jolly, "Interactive graph cuts", ICCV 2001, and Boykov and Kolmogorov, "An experimental
// comparison of min-cut/max-flow algorithms", IEEE TPAMI 26, 2004, as the Boost Graph Library has it.
#pragma once

#include <functional>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// What a voxel is before the cut. Only free voxels cost memory: some 250 bytes each.
enum class CutState : std::uint8_t { background, object, free };

struct CutProblem {
    patient::LabelVolume state;  // CutStates
    FloatVolume preference;      // of a free voxel: above 0 to be object, below 0 to be background
    // What it costs to separate two of six neighbours, by their offsets in the grid; not negative, symmetric.
    std::function<float(std::size_t, std::size_t)> link;
};

// The object: the voxels that were it, and the free ones on its side of the cut whose cost is least. Costs
// count to a thousandth, so that the result is exact and the same everywhere.
Mask minimumCut(const CutProblem&);

}  // namespace stylet::modeller
