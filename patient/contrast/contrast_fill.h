// Fills voxels in order of distance behind a blurred front. The filled volume determines the position of
// the front; the front determines the filled share of each voxel.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

namespace stylet::patient {

// The share falls linearly from 1 to 0 across a zone centred on the front. The zone widens with the
// distance that the front has travelled (dispersion).
struct FrontShape {
    double width_m = 0.002;
    double growth = 0.1;  // at most 2: beyond that the nearest voxels would never be full

    double widthAt(double front_m) const noexcept { return width_m + growth * std::max(front_m, 0.0); }
    double share(double front_m, double path_m) const noexcept {
        return std::clamp((front_m - path_m) / widthAt(front_m) + 0.5, 0.0, 1.0);
    }
};

// Cumulative capacity by distance. Entries with an infinite distance are left out.
class FillOrder {
  public:
    FillOrder() = default;
    FillOrder(std::span<const double> path_m, std::span<const double> capacity_m3);

    double total() const noexcept { return capacity_m3_.empty() ? 0.0 : capacity_m3_.back(); }
    double furthest_m() const noexcept { return path_m_.empty() ? 0.0 : path_m_.back(); }
    // Sum of capacity * share with the front at `front_m`.
    double filled(const FrontShape&, double front_m) const noexcept;
    // Position of the front when `volume_m3` (at most total()) is filled, accurate to rounding. noexcept,
    // no allocation.
    double frontPosition_m(const FrontShape&, double volume_m3) const noexcept;

  private:
    std::vector<double> path_m_;  // ascending
    // Prefix sums, starting with zero: of the capacity, and of capacity times distance.
    std::vector<double> capacity_m3_, moment_m4_;
};

}  // namespace stylet::patient
