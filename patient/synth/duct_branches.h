// Branches of a tubular label, from its voxels alone.
#pragma once

#include <vector>

#include "patient/volume.h"

namespace stylet::patient::synth {

struct Branch {
    double length_mm = 0.0;
    double diameter_mm = 0.0;  // of a circle as large as the median cross-section
};

// `voxels` are offsets into the grid; what does not hang together with their widest place is left out.
std::vector<Branch> tubeBranches(const LabelVolume&, const std::vector<std::size_t>& voxels);

// Distance of every voxel of a piece to the nearest voxel outside of it, in mm, up to `limit_mm`; half a
// voxel less than between centres, so that a tube's middle reads its radius.
std::vector<double> depthInside(const LabelVolume&, const std::vector<std::size_t>& voxels, double limit_mm);

}  // namespace stylet::patient::synth
