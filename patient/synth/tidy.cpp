#include <array>

#include "patient/synth/components.h"
#include "patient/synth/painters.h"

namespace stylet::patient::synth {

namespace {

// Organs that must be in one piece.
constexpr IdSet kWhole =
    anyOf({Id::lungRight, Id::lungLeft, Id::heart, Id::aorta, Id::cava, Id::liver, Id::portal,
           Id::hepaticVeins, Id::ducts, Id::gallbladder, Id::tumour, Id::spleen, Id::pancreas,
           Id::kidneyRight, Id::kidneyLeft, Id::stomach, Id::colon, Id::bowel, Id::diaphragm});

// The most frequent label around a piece.
std::uint8_t surroundings(const LabelVolume& labels, const Component& c) {
    std::array<std::size_t, std::size_t(kIdCount)> count{};
    const Grid& grid = labels.grid;
    for (const std::size_t n : c.voxels) {
        const Index3 i = grid.voxelAt(n);
        for (int axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                Index3 j = i;
                j[axis] += step;
                // Never fill with fascia, which must stay one voxel thick.
                if (grid.contains(j) && labels[j] != c.label && labels[j] != std::uint8_t(Id::fascia))
                    ++count[labels[j]];
            }
    }
    std::size_t best = std::size_t(Id::visceralFat);
    for (std::size_t k = 0; k < count.size(); ++k)
        if (count[k] > count[best]) best = k;
    return std::uint8_t(best);
}

}  // namespace

void removeIslands(Canvas& canvas) {
    std::vector<bool> wanted(256, false);
    for (int i = 0; i < kIdCount; ++i)
        wanted[std::size_t(i)] = holds(kWhole, std::uint8_t(i));
    // Filling an island of one organ can join or split pieces of another; a few rounds are enough.
    for (int round = 0; round < 3; ++round) {
        const std::vector<Component> all = components(canvas.labels, wanted);
        std::array<std::size_t, std::size_t(kIdCount)> largest{};
        for (const Component& c : all)
            largest[c.label] = std::max(largest[c.label], c.voxels.size());
        bool clean = true;
        std::array<bool, std::size_t(kIdCount)> kept{};
        for (const Component& c : all) {
            if (c.voxels.size() == largest[c.label] && !kept[c.label]) {
                kept[c.label] = true;
                continue;
            }
            clean = false;
            const std::uint8_t fill = surroundings(canvas.labels, c);
            for (const std::size_t n : c.voxels)
                canvas.labels.voxels[n] = fill, canvas.detail[n] = 128;
        }
        if (clean) return;
    }
}

}  // namespace stylet::patient::synth
