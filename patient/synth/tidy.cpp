#include <array>

#include "patient/synth/painters.h"

namespace stylet::patient::synth {

namespace {

// The most frequent label around a component, except fascia.
std::uint8_t surroundings(const LabelVolume& labels, const std::vector<std::size_t>& component) {
    std::array<std::size_t, std::size_t(kIdCount)> count{};
    const std::uint8_t own = labels.voxels[component.front()];
    for (const std::size_t n : component)
        for (const Index3& step : kFaceSteps) {
            const Index3 i = labels.grid.voxelAt(n) + step;
            // Never fill with fascia, which must stay one voxel thick.
            if (labels.grid.contains(i) && labels[i] != own && labels[i] != std::uint8_t(Id::fascia))
                ++count[labels[i]];
        }
    std::size_t best = std::size_t(Id::visceralFat);
    for (std::size_t k = 0; k < count.size(); ++k)
        if (count[k] > count[best]) best = k;
    return std::uint8_t(best);
}

}  // namespace

void removeIslands(Canvas& canvas) {
    // Filling an island of one organ can join or split pieces of another. Three rounds are enough.
    for (int round = 0; round < 3; ++round) {
        const auto components = connectedComponents(canvas.labels, labelSet(kConnectedOrgans));
        std::array<const std::vector<std::size_t>*, std::size_t(kIdCount)> largest{};
        for (const std::vector<std::size_t>& component : components) {
            auto& best = largest[canvas.labels.voxels[component.front()]];
            if (!best || component.size() > best->size()) best = &component;
        }
        bool clean = true;
        for (const std::vector<std::size_t>& component : components) {
            if (&component == largest[canvas.labels.voxels[component.front()]]) continue;
            clean = false;
            const std::uint8_t fill = surroundings(canvas.labels, component);
            for (const std::size_t n : component)
                canvas.labels.voxels[n] = fill, canvas.detail[n] = 128;
        }
        if (clean) return;
    }
}

}  // namespace stylet::patient::synth
