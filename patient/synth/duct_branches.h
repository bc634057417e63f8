// Measures the branches of a tubular label from its voxels.
#pragma once

#include <vector>

#include "base/volume.h"

namespace stylet::patient::synth {

struct Branch {
    double length_mm = 0.0;
    double diameter_mm = 0.0;  // of a circle with the area of the median cross-section
};

// `voxels` are offsets into the grid, ascending. Only the largest connected piece is measured.
std::vector<Branch> tubeBranches(const LabelVolume&, const std::vector<std::size_t>& voxels);

// Distance [mm] of every voxel of a piece to the nearest voxel outside it, at most `limit_mm`. This is the
// distance between centres minus half a voxel, so that the value in the middle of a tube is its radius.
std::vector<double> depthInside(const LabelVolume&, const std::vector<std::size_t>& voxels, double limit_mm);

}  // namespace stylet::patient::synth
