// Refines the liver's border on the CT's own voxels, starting from a border that is a few voxels off.
// Based on Lankton and Tannenbaum, "Localizing region-based active contours", IEEE Trans Image Process 17,
// 2008 (borders from local means on both sides), and Boykov and Jolly 2001 (graph cut).
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// CT values of the parenchyma.
struct Parenchyma {
    float mean_hu = 0.0f, sigma_hu = 0.0f;
};

// Adds the vessels between parts of the liver, where `open` allows it, and fills holes in the liver.
void closeLiver(Mask& liver, const Mask& open);

// `first` may be on any grid and must not be empty. Its border moves by at most `band_m`. `open`, on the
// CT's grid, is where organs can be: inside the body, not lung, not bone.
Mask refineLiver(const CtVolume&, const Mask& open, const Mask& first, const Parenchyma&, double band_m);

}  // namespace stylet::modeller
