// How sharp a scan is, measured in the scan itself. Based on Sanders, Hurwitz and Samei, "Patient-specific
// quantification of image quality: An automated method for measuring spatial resolution in clinical CT
// images", Med. Phys. 43, 2016: the edge between skin and air.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// That of the reference patients, which [1 2 1]/4 along each axis blurs in voxels of 1 mm.
inline constexpr double kUsualBlur_m = 0.0007;

// The standard deviation of the blur within a slice: that of the scanner and of the voxels together. Measured
// where the skin of the body's front is almost perpendicular to the y axis. Needs the air around the body.
// kUsualBlur_m if too little of such skin is visible, or if the air was cut away.
double measureBlur(const CtVolume&);

}  // namespace stylet::modeller
