// Bright or dark tubes in a volume: vessels, ducts.
// Based on Sato et al., "Three-dimensional multi-scale line filter for segmentation and visualization of
// curvilinear structures in medical images", Medical Image Analysis 2, 1998.
#pragma once

#include "app/modeller/image/morphology.h"

namespace stylet::modeller {

// Pastes `part` into the whole grid at the box; 0 elsewhere.
Mask uncropped(const Mask& part, const VoxelBox&, const Grid& whole);

enum class TubeKind { bright, dark };

// Sato's line measure at one scale, in the image's unit (eq. 9 with gamma23 = gamma12 = 1, derivatives
// times sigma^2). For ordered eigenvalues l1 >= l2 >= l3 of the Hessian, if both l2 and l3 < 0:
//     |l2| - |l1| if l1 <= 0, else |l2| - alpha l1.
// On the axis of a long cylinder of radius R and contrast C it is C (R^2 / 2 sigma^2) exp(-R^2 / 2
// sigma^2), with the maximum C / e at sigma = R / sqrt(2). It is 0 on plates and in the centre of balls.
// Voxels outside `within` stay 0. Outside the grid the border values are repeated. `sigma_m` is raised to
// at least 0.5 voxels.
FloatVolume tubeResponse(const FloatVolume& image, const Mask& within, double sigma_m, TubeKind);

// Gaussian blur with the same kernels.
FloatVolume gaussian(const FloatVolume& image, double sigma_m);

}  // namespace stylet::modeller
