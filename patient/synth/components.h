// Connected components of labels.
#pragma once

#include <cstdint>
#include <vector>

#include "base/volume.h"

namespace stylet::patient::synth {

struct Component {
    std::uint8_t label = 0;
    std::vector<std::size_t> voxels;  // in flood-fill order
};

// 26-connected components of every label with `wanted[label]`, ordered by their first voxel.
std::vector<Component> components(const LabelVolume&, const std::vector<bool>& wanted);

}  // namespace stylet::patient::synth
