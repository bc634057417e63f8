// Bright or dark tubes in a volume: vessels, ducts.
// Based on Sato et al., "Three-dimensional multi-scale line filter for segmentation and visualization of
// curvilinear structures in medical images", Medical Image Analysis 2, 1998.
#pragma once

#include "app/modeller/build/morphology.h"

namespace stylet::modeller {

// Around all voxels of the mask, `margin` voxels more on every side, within the grid.
VoxelBox boxAround(const Mask&, int margin);
patient::Grid gridOf(const patient::Grid& whole, const VoxelBox&);
// Back into a grid of which `part` is the box; 0 elsewhere.
Mask restored(const Mask& part, const VoxelBox&, const patient::Grid& whole);

enum class TubeKind { bright, dark };

// Sato's line measure at one scale, in the unit of the image (eq. 9 with gamma23 = gamma12 = 1, derivatives
// times sigma^2): for ordered eigenvalues l1 >= l2 >= l3 of the Hessian, both l2 and l3 < 0,
//     |l2| - |l1| where l1 <= 0, |l2| - alpha l1 above.
// On the axis of a long cylinder of radius R and contrast C it is C (R^2 / 2 sigma^2) exp(-R^2 / 2 sigma^2):
// greatest, C / e, at sigma = R / sqrt(2). 0 on plates and in the middle of balls. Voxels that `within`
// leaves out stay 0. Beyond the grid the outermost voxels go on. `sigma_m` is at least 0.5 voxels, else it is
// taken so.
FloatVolume tubeResponse(const FloatVolume& image, const Mask& within, double sigma_m, TubeKind);

// Gaussian blur, by the same kernels.
FloatVolume gaussian(const FloatVolume& image, double sigma_m);

}  // namespace stylet::modeller
