// The spinal canal: soft, round, hemmed in by bone, and in one smooth line from the feet to the head. What
// else a bone is, is told from where it lies to it.
#pragma once

#include <vector>

#include "app/modeller/build/morphology.h"

namespace stylet::modeller {

struct SpinalCanal {
    Mask voxels;
    std::vector<patient::Vec3> centres_m;  // slice by slice where it shows, from the feet up
};

// `shell`: the bright voxels of cortex; `body`: the box it lies in.
SpinalCanal findCanal(const patient::CtVolume&, const Mask& shell, const VoxelBox& body);

}  // namespace stylet::modeller
