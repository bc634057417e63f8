// How sharp a scan is, measured in the scan itself. Based on Sanders, Hurwitz and Samei, "Patient-specific
// quantification of image quality: An automated method for measuring spatial resolution in clinical CT
// images", Med. Phys. 43, 2016: the edge between skin and air.
#pragma once

#include <optional>
#include <string>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Blur of the reference patients: [1 2 1]/4 along each axis, in voxels of 1 mm.
inline constexpr double kUsualBlur_m = 0.0007;

// More blur within slices than this hides the fat between liver and diaphragm.
inline constexpr double kHidesDiaphragm_m = 0.001;

// Standard deviation of the blur of the scanner, of its slices and of the voxels together.
struct ScanBlur {
    double within_m = kUsualBlur_m;                       // within a slice: along x and y
    double across_m = kUsualBlur_m;                       // across slices: along z
    bool within_assumed = false, across_assumed = false;  // true: not visible in the scan
};

// Measures both. If the blur within slices is not visible, that of the reference patients is assumed. If the
// blur across slices is not visible, it is assumed to equal the blur within slices.
ScanBlur measureBlur(const CtVolume&);
// One line for people.
std::string blurText(const ScanBlur&);

// Measured where the skin of the body's front is almost perpendicular to the y axis. None if too little of
// such skin is visible, or if the air around the body was cut away. Without noise the error is at most 8 % up
// to 1.5 voxels. A blur of 2.5 voxels is measured as 2.
std::optional<double> measureBlurWithin(const CtVolume&);

// Thick slices and their interpolation add to the blur across slices. Measured at the lungs' bases,
// where the diaphragm is almost perpendicular to the z axis. None if too little of it is visible, or if the
// blur is more than 3 voxels. A diaphragm that moves during the scan looks blurred.
std::optional<double> measureBlurAcross(const CtVolume&);

}  // namespace stylet::modeller
