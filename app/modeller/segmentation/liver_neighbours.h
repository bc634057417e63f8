// Separates the liver from touching organs that are hardly darker and have no fat between: pancreas,
// duodenum, bowel wall.
#pragma once

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Mean over a cube of 2 * reach + 1 voxels per side, of the values in `within` that differ from the
// centre's value by at most `alike`. Preserves larger edges. Lee, "Digital image smoothing and the sigma
// filter", Computer Vision, Graphics, and Image Processing 24, 1983. The image is unchanged outside
// `within`.
FloatVolume sigmaFiltered(const FloatVolume& image, const Mask& within, float alike, int reach);

// Subtracts from `hu` the local excess of the `core` voxels over `mean_hu` (two cubes of 2 * reach + 1
// voxels per side). Removes the unevenness caused by fat and by the flow of contrast medium. Far from the
// core nothing changes.
FloatVolume levelled(const FloatVolume& hu, const Mask& core, float mean_hu, int reach);

// Finds lumps on `liver` whose border is next to `alike`, voxels outside that could also be liver. There a
// cut ran through another organ; the liver's own lobes and edges end at different tissue. A lump is a part
// that a ball of `radius_m` inside the thickest part does not reach.
Mask endlessLumps(const Mask& liver, const Mask& alike, double radius_m);

}  // namespace stylet::modeller
