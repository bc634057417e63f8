#include "app/modeller/image/mask_runs.h"

#include <algorithm>
#include <utility>

namespace stylet::modeller {

MaskRuns::MaskRuns(const Mask& m, Connectivity touch) : grid_(m.grid) {
    const auto length = std::uint32_t(grid_.dims.x);
    const auto rowAt = [&](int y, int z) {
        return std::size_t(z) * std::size_t(grid_.dims.y) + std::size_t(y);
    };
    const std::size_t rows = rowAt(0, grid_.dims.z);
    first_.reserve(rows + 1);
    for (std::size_t row = 0; row < rows; ++row)
        addRow(m.voxels.data() + row * length, std::uint32_t(row * length), grid_.dims.x);
    first_.push_back(std::uint32_t(runs_.size()));
    const bool corners = touch == Connectivity::corners;
    const std::uint32_t reach = corners ? 1 : 0;
    for (int z = 0; z < grid_.dims.z; ++z)
        for (int y = 0; y < grid_.dims.y; ++y) {
            const std::size_t row = rowAt(y, z);
            if (y > 0) joinRows(row, row - 1, reach);
            if (z == 0) continue;
            joinRows(row, rowAt(y, z - 1), reach);
            if (corners && y > 0) joinRows(row, rowAt(y - 1, z - 1), reach);
            if (corners && y + 1 < grid_.dims.y) joinRows(row, rowAt(y + 1, z - 1), reach);
        }
    numberComponents();
}

void MaskRuns::addRow(const std::uint8_t* row, std::uint32_t offset, int length) {
    first_.push_back(std::uint32_t(runs_.size()));
    const std::uint8_t* const end = row + length;
    for (const std::uint8_t* at = nextSet(row, end); at != end;) {
        const std::uint8_t* const behind = std::find(at, end, std::uint8_t{0});
        runs_.push_back({offset + std::uint32_t(at - row), offset + std::uint32_t(behind - row),
                         std::uint32_t(runs_.size())});
        at = nextSet(behind, end);
    }
}

// Joins the runs of two rows that overlap. With a reach of 1, runs that touch at a corner are joined, too.
void MaskRuns::joinRows(std::size_t row, std::size_t other, std::uint32_t reach) {
    const auto shift = std::uint32_t((row - other) * std::size_t(grid_.dims.x));
    for (std::uint32_t a = first_[row], b = first_[other]; a < first_[row + 1] && b < first_[other + 1];) {
        const std::uint32_t b_begin = runs_[b].begin + shift, b_end = runs_[b].end + shift;
        if (runs_[a].begin < b_end + reach && b_begin < runs_[a].end + reach) {
            auto [low, high] = std::minmax({root(a), root(b)});
            runs_[high].component = low;
        }
        runs_[a].end < b_end ? ++a : ++b;
    }
}

// Returns the first run of the component, as far as it is joined, and halves the path to it.
std::uint32_t MaskRuns::root(std::uint32_t run) {
    while (runs_[run].component != run)
        run = runs_[run].component = runs_[runs_[run].component].component;
    return run;
}

void MaskRuns::numberComponents() {
    counts_.assign(1, 0);
    for (std::uint32_t i = 0; i < runs_.size(); ++i) {
        Run& run = runs_[i];
        if (run.component == i) {
            run.component = std::uint32_t(counts_.size());
            counts_.push_back(0);
        } else {
            run.component = runs_[run.component].component;  // an earlier run, which has its number
        }
        counts_[run.component] += run.end - run.begin;
    }
}

}  // namespace stylet::modeller
