// What tells the liver from organs that are hardly darker and lie against it with no fat between: pancreas,
// duodenum, a bowel's wall.
#pragma once

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// The mean of those values of `within` in a cube of 2 * reach + 1 voxels a side that differ from the middle's
// by at most `alike`; edges higher than that stay. Lee, "Digital image smoothing and the sigma filter",
// Computer Vision, Graphics, and Image Processing 24, 1983. Outside `within` the image is unchanged.
FloatVolume sigmaFiltered(const FloatVolume& image, const Mask& within, float alike, int reach);

// `hu` less what the voxels of `core` measure around (two cubes of 2 * reach + 1 voxels a side) above
// `mean_hu`: fat and the flow of contrast medium make a liver uneven. Far from the core nothing changes.
FloatVolume levelled(const FloatVolume& hu, const Mask& core, float mean_hu, int reach);

// Lumps on `liver` that end within `alike`, voxels beyond it that could as well be liver: there a cut went
// through another organ, for the liver's own lobes and edges end at something else. A lump is what a ball of
// `radius_m` in the thickest part does not reach.
Mask endlessLumps(const Mask& liver, const Mask& alike, double radius_m);

}  // namespace stylet::modeller
