// What lies round the reference path: how near the needle comes to what it must not touch, and to the ducts
// it is meant for. Made once for a patient and a path.
#pragma once

#include <optional>

#include "patient/patient.h"

namespace stylet::training {

// So far to every side of the path the patient is looked at.
inline constexpr double kSurroundings_m = 0.040;

class Surroundings {
  public:
    Surroundings(const patient::Patient&, const patient::PlannedPath&);

    // Session thread. noexcept, no allocation. Distance to the border of the nearest risk structure (0 in
    // one), by the voxels' centres less half a voxel, as the planner has it. Infinite where none is near
    // enough to be known.
    double toRisk_m(const patient::Vec3& reference_m) const noexcept {
        return toBorder(risk_m_, reference_m);
    }
    // The same to the ducts of the target role.
    double toDuct_m(const patient::Vec3& reference_m) const noexcept {
        return toBorder(duct_m_, reference_m);
    }
    // The way the target duct runs at the target (unit); none where it has no length.
    const std::optional<patient::Vec3>& ductAlong() const noexcept { return duct_along_; }

  private:
    double toBorder(const patient::Volume<float>&, const patient::Vec3&) const noexcept;

    patient::Volume<float> risk_m_, duct_m_;
    double half_voxel_m_ = 0.0;
    std::optional<patient::Vec3> duct_along_;
};

}  // namespace stylet::training
