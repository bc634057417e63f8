#include "patient/synth/components.h"

namespace stylet::patient::synth {

std::vector<Component> components(const LabelVolume& labels, const std::vector<bool>& wanted) {
    const Grid& grid = labels.grid;
    std::vector<bool> seen(labels.voxels.size(), false);
    std::vector<Component> found;
    const auto nx = std::size_t(grid.dims.x), ny = std::size_t(grid.dims.y);
    for (std::size_t start = 0; start < seen.size(); ++start) {
        if (seen[start] || !wanted[labels.voxels[start]]) continue;
        Component c{labels.voxels[start], {start}};
        seen[start] = true;
        for (std::size_t k = 0; k < c.voxels.size(); ++k) {
            const std::size_t n = c.voxels[k];
            const Index3 i{int(n % nx), int(n / nx % ny), int(n / (nx * ny))};
            for (int dz = -1; dz <= 1; ++dz)
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx) {
                        const Index3 j{i.x + dx, i.y + dy, i.z + dz};
                        if (!grid.contains(j)) continue;
                        const std::size_t m = grid.offset(j);
                        if (seen[m] || labels.voxels[m] != c.label) continue;
                        seen[m] = true;
                        c.voxels.push_back(m);
                    }
        }
        found.push_back(std::move(c));
    }
    return found;
}

}  // namespace stylet::patient::synth
