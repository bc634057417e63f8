// Refines the liver's border on the CT's own voxels, starting from a border that is a few voxels off.
// Based on Lankton and Tannenbaum, "Localizing region-based active contours", IEEE Trans Image Process 17,
// 2008 (borders from local means on both sides), Boykov and Jolly 2001 (graph cut), and Treece et al., "High
// resolution cortical thickness measurement from clinical CT data", Med Image Anal 14, 2010 (a blurred thin
// layer between two tissues, fitted to each profile).
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// CT values of the parenchyma.
struct Parenchyma {
    float mean_hu = 0.0f, sigma_hu = 0.0f;
};

// Adds the vessels between parts of the liver, where `open` allows it, and fills holes in the liver.
void closeLiver(Mask& liver, const Mask& open);

// Moves the border of `cut`, by at most 2.5 mm, to the edge in the profiles of CT values across it. Liver may
// be separated from its neighbour by a film of fat that is thinner than the blur. Smoothed over neighbouring
// profiles. Profiles that reach lung or gas are ignored, because the diaphragm before the lung looks like
// liver. For voxels finer than 1.5 mm.
Mask fitBorder(const FloatVolume& hu, const Mask& open, const Mask& cut, const Parenchyma&, double blur_m);

// `first` may be on any grid and must not be empty. Its border moves by at most `band_m`. `open`, on the
// CT's grid, is where organs can be: inside the body, not lung, not bone.
Mask refineLiver(const CtVolume&, const Mask& open, const Mask& first, const Parenchyma&, double band_m,
                 double blur_m);

}  // namespace stylet::modeller
