// Finds the voxels of bone: cortex by its brightness, marrow by the cortex around it.
#pragma once

#include "app/modeller/segmentation/spinal_canal.h"

namespace stylet::modeller {

// Halfway between muscle (55) and a cortex blurred over a rib's millimetre (350).
inline constexpr std::int16_t kBone_hu = 200;

// True if the voxel is so close to the front surface (along y) that it can be sternum but not kidney.
bool isInFrontWall(const Mask& body, const Index3& at);

// Pieces above kBone_hu that are bone: they contain enough certain cortex, or are in the front wall.
Mask bonePieces(const CtVolume&, const Mask& body);
// The bright voxels near cortex. Vessel or kidney parts of a piece are farther from any cortex.
Mask shellOf(const CtVolume&, const Mask& pieces);
// The first thing found within `count` steps from a voxel.
enum class Met { bone, nothing, border };
Met meets(const Mask& wall, Index3 at, const Index3& step, int count);
// Fills spongy bone: voxels enclosed by cortex, even if less bright than bone. Runs in rounds, because the
// first fill encloses further voxels. Inside vertebrae less enclosure is needed; a vessel beside one is
// enclosed on one side only. Narrow marrow (ribs, arches) may be as dark as fat.
Mask withMarrow(const CtVolume&, const Mask& body, const Mask& pieces, const Mask& shell, const SpinalCanal&);

}  // namespace stylet::modeller
