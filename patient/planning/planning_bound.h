// Internal: finds pairs of skin and duct voxel that cannot be the best, with few samples. Based on Hart,
// "Sphere tracing", The Visual Computer 12, 1996.
#pragma once

#include "patient/planning/planning_judge.h"

namespace stylet::patient {

// Computes an upper bound of a path's quality from few samples. Uses a sample only if the path certainly
// visits its voxel: the sampled point of the line is in the voxel and not close to its faces. So the bound is
// never below PathEvaluator's result, not even by a rounding error.
class QualityBound {
  public:
    // The plan must outlive it. Its breath must be that of the CT.
    explicit QualityBound(const Plan&);
    // An upper bound of the path's quality. Stops early and returns a value below `needed` once the quality
    // is known to be below it.
    double bound(const PlannedPath&, double needed) const;

  private:
    struct Line;
    double clearance(const Index3& voxel) const;
    bool blocks(const Index3& voxel) const;
    bool isDuct(const Index3& voxel) const;
    double outsideDuct(const Line&, double from_m, double last_m, double step_m) const;

    const Plan& plan_;
    const Grid& grid_;
    Index3 corner_;  // first voxel of the region in the patient's grid
    double half_voxel_m_ = 0.0;
};

}  // namespace stylet::patient
