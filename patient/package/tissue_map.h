// The tissue rule of Patient::at() (Mastmeyer et al. 2017, Algorithm 1) for whole volumes. Encodes label and
// CT class of each voxel in one byte, so that a walk along a path reads a single array. Built once per
// patient for the path planner and for the study (app/study), which walk along millions of paths.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/traversal.h"
#include "patient/package/package.h"

namespace stylet::patient {

class TissueMap {
  public:
    using Code = std::uint8_t;

    // Classifies every voxel. Throws DataError if the labels in use and the CT classes need more than 256
    // codes.
    explicit TissueMap(const Patient&);

    const Grid& grid() const noexcept { return grid_; }
    const TissueTable& tissues() const noexcept { return tissues_; }
    // Voxels with the same code do not differ in tissue for any track flags. Outside the grid the code is
    // that of air. noexcept, no allocation.
    Code code(const Index3& i) const noexcept {
        return grid_.contains(i) ? codes_[grid_.offset(i)] : kOutside;
    }
    Code code(const VoxelPath::Visit& visit) const noexcept {
        return visit.offset == VoxelPath::kOutside ? kOutside : codes_[std::size_t(visit.offset)];
    }
    // Same as Patient::at() and Patient::flagsAfterEntering() at a voxel with this code.
    const TissueSample& sample(Code code, TrackFlags flags) const noexcept {
        return entries_[flagBits(flags)][code].sample;
    }
    TrackFlags flagsAfterEntering(Code code, TrackFlags before) const noexcept {
        return entries_[flagBits(before)][code].flags_after;
    }

  private:
    struct Entry {
        TissueSample sample;
        TrackFlags flags_after;
    };
    static constexpr Code kOutside = 0;
    static std::size_t flagBits(TrackFlags f) noexcept {
        return std::size_t(f.past_skin) | std::size_t(f.past_fascia) << 1;
    }

    Grid grid_;
    TissueTable tissues_;
    std::vector<Code> codes_;
    std::array<std::array<Entry, 256>, 4> entries_{};
};

}  // namespace stylet::patient
