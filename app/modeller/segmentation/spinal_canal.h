// Finds the spinal canal: soft, round, enclosed by bone, and one smooth line from feet to head. Other bones
// are identified by their position relative to it.
#pragma once

#include <vector>

#include "app/modeller/image/morphology.h"

namespace stylet::modeller {

struct SpinalCanal {
    Mask voxels;
    std::vector<Vec3> centres_m;  // in each slice where it is visible, from the feet up
};

// `shell`: the bright voxels of cortex. `body`: the body's bounding box.
SpinalCanal findCanal(const CtVolume&, const Mask& shell, const VoxelBox& body);

}  // namespace stylet::modeller
