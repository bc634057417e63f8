// Separates the liver from what touches it, is hardly darker and not separated by fat: pancreas, duodenum,
// bowel wall, and the wall between the ribs.
#pragma once

#include <initializer_list>

#include "app/modeller/wall/body_wall.h"

namespace stylet::modeller {

// Mean over a cube of 2 * reach + 1 voxels per side, of the values in `within` that differ from the
// centre's value by at most `max_difference`. Preserves larger edges. Lee, "Digital image smoothing and the
// sigma filter", Computer Vision, Graphics, and Image Processing 24, 1983. The image is unchanged outside
// `within`.
FloatVolume sigmaFiltered(const FloatVolume& image, const Mask& within, float max_difference, int reach);

// Corrects the unevenness caused by fat and by the flow of contrast medium. Subtracts from `hu` the local
// excess of the `core` voxels over `mean_hu`, averaged twice over cubes of 2 * reach + 1 voxels per side. Far
// from the core nothing changes.
FloatVolume correctBias(const FloatVolume& hu, const Mask& core, float mean_hu, int reach);

// Finds lumps of `liver` that belong to another organ, because a cut ran through that organ. A lump is a part
// that a ball of `radius_m` inside the thickest part does not reach. Three measures are summed: the share of
// its border that is the rest of the liver, the `prior` probability of liver in it, and the share of its free
// border next to `similar`, the voxels outside that could also be liver. The liver's own lobes end at
// different tissue, and a tip is broad at its base. What the prior calls liver is never returned.
Mask findLeakedLumps(const Mask& liver, const Mask& similar, const FloatVolume& prior, double radius_m);

// Clears the masks' voxels outside a smooth surface `gap_m` inside the inner side of the ribs, also between
// ribs. Changes nothing where no bone is near. `in.bones` are wallBones() that were found with the liver,
// `in.organs` the lungs. A mask may be on a grid of its own.
void removeOutsideRibs(const FasciaInput& in, double gap_m, std::initializer_list<Mask*> masks);

}  // namespace stylet::modeller
