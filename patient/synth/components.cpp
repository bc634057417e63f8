#include "patient/synth/components.h"

#include "base/geodesic.h"

namespace stylet::patient::synth {

std::vector<Component> components(const LabelVolume& labels, const std::vector<bool>& wanted) {
    std::vector<bool> seen(labels.voxels.size(), false);
    std::vector<Component> found;
    for (std::size_t start = 0; start < seen.size(); ++start) {
        if (seen[start] || !wanted[labels.voxels[start]]) continue;
        const std::uint8_t label = labels.voxels[start];
        const auto in = [&](std::size_t offset) { return labels.voxels[offset] == label; };
        found.push_back({label, connectedVoxels(labels.grid, start, in, seen)});
    }
    return found;
}

}  // namespace stylet::patient::synth
