// Surroundings of the reference path: distance of the needle to risk structures and to the target ducts.
// Computed once per patient and path.
#pragma once

#include <optional>

#include "patient/patient.h"

namespace stylet::training {

// Margin around the path in which distances are known.
inline constexpr double kSurroundingsMargin_m = 0.040;

class Surroundings {
  public:
    Surroundings(const patient::Patient&, const patient::PlannedPath&);

    // Session thread. noexcept, no allocation. Distance to the border of the nearest risk structure (0
    // inside one). As in the planner, it is measured between voxel centres, minus half a voxel. Infinite
    // outside the margin.
    double distanceToRisk_m(const Vec3& reference_m) const noexcept { return toBorder(risk_m_, reference_m); }
    // The same for ducts of the target role.
    double distanceToDuct_m(const Vec3& reference_m) const noexcept { return toBorder(duct_m_, reference_m); }
    // Direction of the target duct at the target (unit vector); nothing if the duct has no clear direction.
    const std::optional<Vec3>& ductAxis() const noexcept { return duct_axis_; }

  private:
    double toBorder(const Volume<float>&, const Vec3&) const noexcept;

    Volume<float> risk_m_, duct_m_;
    double half_voxel_m_ = 0.0;
    std::optional<Vec3> duct_axis_;
};

}  // namespace stylet::training
