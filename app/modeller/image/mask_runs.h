// The runs of set voxels along the rows of a mask, and which of them are connected. A mask has far fewer runs
// than voxels, so finding its components costs little more than one look at each voxel. Cf. He, Chao and
// Suzuki, "A Run-Based Two-Scan Labeling Algorithm", IEEE TIP 17, 2008.
#pragma once

#include <cstdint>
#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

struct Run {
    std::uint32_t begin, end;  // offsets of the first voxel and behind the last one, in one row
    std::uint32_t component;   // from 1, in the order of the components' first voxels
};

class MaskRuns {
  public:
    MaskRuns(const Mask&, Connectivity);
    const std::vector<Run>& runs() const { return runs_; }  // in memory order
    const std::vector<std::size_t>& size() const {
        return size_;
    }  // of each component, in voxels; size[0] is 0
    // Mask of the components for which keep(number) is true.
    template <typename Keep>
    Mask where(const Keep& keep) const {
        std::vector<std::uint8_t> kept(size_.size(), 0);
        for (std::size_t n = 1; n < kept.size(); ++n)
            kept[n] = keep(n);
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
    std::vector<Run>
        runs_;  // while they are joined, `component` is another run of the same component, or itself
    std::vector<std::uint32_t> first_;  // run of each row, and the end
    std::vector<std::size_t> size_;
};

}  // namespace stylet::modeller
