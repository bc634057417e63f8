// Connected components of labels.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/volume.h"

namespace stylet::patient::synth {

struct Component {
    std::uint8_t label = 0;
    std::vector<std::size_t> voxels;  // in the order a flood found them
};

// 26-connected pieces of equal label, of every label for which `wanted[label]`. Ordered by their first voxel.
std::vector<Component> components(const LabelVolume&, const std::vector<bool>& wanted);

}  // namespace stylet::patient::synth
