// The liver's border on the CT's own voxels, from one that is a few voxels off.
// Based on Lankton and Tannenbaum, "Localizing region-based active contours", IEEE Trans Image Process 17,
// 2008 (a border is where the local means on either side say), and Boykov and Jolly 2001 (as a graph cut).
#pragma once

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// CT values of the parenchyma.
struct Parenchyma {
    float mean_hu = 0.0f, sigma_hu = 0.0f;
};

// Adds to `liver` the vessels between its parts, where `open` allows, and its holes.
void closeLiver(Mask& liver, const Mask& open);

// `first` on any grid, with a voxel in it; moved by at most `band_m`. `open`, on the CT's grid, is where an
// organ can be: within the body, no lung, no bone.
Mask refineLiver(const patient::CtVolume&, const Mask& open, const Mask& first, const Parenchyma&,
                 double band_m);

}  // namespace stylet::modeller
