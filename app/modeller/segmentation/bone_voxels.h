// Finds the voxels of bone: cortex by its brightness, marrow by the cortex around it.
#pragma once

#include "app/modeller/image/scan_blur.h"
#include "app/modeller/segmentation/spinal_canal.h"
#include "app/modeller/wall/bone_border.h"

namespace stylet::modeller {

// True if the voxel is so close to the front surface (along y) that it can be sternum but not kidney.
bool isInFrontWall(const Mask& body, const Index3& at);

struct BonePieces {
    Mask voxels;
    double limit_scale = 1.0;  // factor for the limits of cortex, from the kidneys' brightness: 1 to 1.35
};
// Pieces above kBone_hu that are bone: they contain enough certain cortex, or are in the front wall. Kidneys
// are left out.
BonePieces bonePieces(const BoneScan&);
// The bright voxels near cortex, which is searched in the scan and in the sharpened scan. Vessel or kidney
// parts of a piece are farther from any cortex.
Mask cortexShell(const BoneScan&, const BonePieces&);
// The first thing found within `count` steps from a voxel.
enum class RayHit { bone, nothing, border };
RayHit castRay(const Mask& wall, Index3 at, const Index3& step, int count);
// Fills spongy bone: voxels enclosed by cortex, even if less bright than bone. Repeats the fill, because
// filled voxels enclose further ones. Inside vertebrae, a smaller share of bone around a voxel is sufficient;
// a vessel beside a vertebra has bone on one side only. Narrow marrow (ribs, arches) may be as dark as fat.
Mask withMarrow(const BoneScan&, const Mask& pieces, const Mask& shell, const SpinalCanal&);

// Smooths the surface of the bones in a soft scan or one of thick slices. There, the borders of bones are
// uncertain by a voxel, and interpolation between slices makes them rough: a needle that passes a rib would
// hit bumps of one voxel. Fills dents only with voxels of `open`. Thin bone stays, unless it is a bump of one
// voxel on a thicker bone. Changes nothing in a sharper scan.
Mask smoothedSurface(Mask bone, const Mask& open, const ScanBlur&);

}  // namespace stylet::modeller
