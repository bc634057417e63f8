// The end of a drain, with its side holes: one definition for the step that asks for holes in the ducts and
// for the contrast medium that flows out of them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::training {

// Positions in the reference patient. `back_m` is a distance from the tip along the drain.
class DrainEnd {
  public:
    explicit DrainEnd(const haptics::AccessOutput&) noexcept;  // of a drain with a path: path_count >= 2
    Vec3 at(double back_m) const noexcept;                     // on the drain's axis
    // Where a side hole opens into a duct: on the axis or, in each direction of the grid, on the surface of a
    // drain of this radius. The axis follows the thinner wire, which may run along the wall.
    std::optional<Vec3> openingIntoDuct(const patient::Patient&, double back_m,
                                        double radius_m) const noexcept;

  private:
    std::array<Vec3, haptics::kMaxPathPoints> path_m_;
    std::size_t count_;
    double depth_m_;
};

}  // namespace stylet::training
