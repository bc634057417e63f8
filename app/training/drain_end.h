// The end of a drain with its side holes. Used to judge whether a drain is placed, and to find where contrast
// medium leaves it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::training {

// Positions in the reference patient.
class DrainEnd {
  public:
    static constexpr int kHoles = 15;  // places that are looked at, evenly along the end

    explicit DrainEnd(const haptics::AccessOutput&) noexcept;  // of a drain with a path: path_count >= 2
    // On the drain's axis, `back_m` behind its tip.
    Vec3 at(double back_m) const noexcept;
    // Where hole 0 to kHoles - 1, counted from the tip, opens into a duct: on the drain's axis or, along each
    // axis of the grid, on its surface. The drain follows the thinner wire, which may run along the wall.
    std::optional<Vec3> opening(const patient::Patient&, int hole, double radius_m) const noexcept;

  private:
    std::array<Vec3, haptics::kMaxPathPoints> path_m_;
    std::size_t count_;
    double depth_m_;
};

// True if the voxel at this point is duct tissue, of a target duct or of any other.
bool isDuctTissue(const patient::Patient&, const Vec3& reference_m) noexcept;

}  // namespace stylet::training
