// Voxels filled nearest first, behind a front that is not sharp: a volume gives the place of the front, the
// front gives every voxel's share.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

namespace stylet::patient {

// The zone over which the share falls from 1 to 0 in a straight line, centred on the front; it widens with
// the way the front has come (dispersion).
struct FrontShape {
    double width_m = 0.002;
    double growth = 0.1;  // <= 2: else the nearest are never full

    double widthAt(double front_m) const noexcept { return width_m + growth * std::max(front_m, 0.0); }
    double share(double front_m, double way_m) const noexcept {
        return std::clamp((front_m - way_m) / widthAt(front_m) + 0.5, 0.0, 1.0);
    }
};

// How much room lies within which way. Ways that are infinite are left out.
class FillOrder {
  public:
    FillOrder() = default;
    FillOrder(std::span<const double> way_m, std::span<const double> room_m3);

    double total() const noexcept { return room_m3_.empty() ? 0.0 : room_m3_.back(); }
    double furthest_m() const noexcept { return way_m_.empty() ? 0.0 : way_m_.back(); }
    // Sum of room * share with the front at `front_m`.
    double filled(const FrontShape&, double front_m) const noexcept;
    // Where the front stands when `volume_m3` (at most total()) is filled, to rounding. noexcept, no
    // allocation.
    double frontOf(const FrontShape&, double volume_m3) const noexcept;

  private:
    std::vector<double> way_m_;  // ascending
    // Sums over the first so many, from zero: of the room, of room times way.
    std::vector<double> room_m3_, moment_m4_;
};

}  // namespace stylet::patient
