// The runs of set voxels along the rows of a mask, and which of them are connected. A mask has far fewer runs
// than voxels, so its components are found quickly. Cf. He, Chao and Suzuki, "A Run-Based Two-Scan Labeling
// Algorithm", IEEE TIP 17, 2008.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct Run {
    std::uint32_t begin, end;  // half-open range of offsets of voxels in one row
    std::uint32_t component;   // from 1, in the order of the components' first voxels
};

class MaskRuns {
  public:
    MaskRuns(const Mask&, Connectivity);
    // In memory order.
    const std::vector<Run>& runs() const { return runs_; }
    // Of each component; voxelCounts()[0] is 0.
    const std::vector<std::size_t>& voxelCounts() const { return counts_; }
    // Mask of the components for which keep(number) is true.
    template <typename Keep>
    Mask where(const Keep& keep) const {
        const std::vector<std::uint8_t> kept = keptComponents(counts_.size(), keep);
        Mask mask(grid_);
        for (const Run& run : runs_)
            if (kept[run.component])
                std::fill(mask.voxels.begin() + run.begin, mask.voxels.begin() + run.end, std::uint8_t{1});
        return mask;
    }

  private:
    void addRow(const std::uint8_t* row, std::uint32_t offset, int length);
    void joinRows(std::size_t row, std::size_t other, std::uint32_t reach);
    std::uint32_t root(std::uint32_t run);
    void numberComponents();

    Grid grid_;
    // While runs are joined, `component` is the index of a run of the same component, or of the run itself.
    std::vector<Run> runs_;
    // The index of each row's first run; last, the number of runs.
    std::vector<std::uint32_t> first_;
    std::vector<std::size_t> counts_;
};

}  // namespace stylet::modeller
