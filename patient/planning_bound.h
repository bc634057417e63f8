// Internal: which pairs of skin and duct cannot win, from few looks. Based on Hart, "Sphere tracing", The
// Visual Computer 12, 1996.
#pragma once

#include "patient/planning_judge.h"

namespace stylet::patient {

// Says of a pair, from few looks, that it cannot come to a quality. Every look that counts is at a voxel that
// the path surely visits: one that holds a point of the line and does not end just there. So what is found
// bounds what Judge would find, to the last bit.
class Doubter {
  public:
    // The plan must outlive it; its breath is that of the CT.
    explicit Doubter(const Plan&);
    // The best quality that the path could have, or something lower than `needed`.
    double bound(const PlannedPath&, double needed) const;

  private:
    struct Line;
    double clearance(const Index3& voxel) const;
    bool blocks(const Index3& voxel) const;
    bool isDuct(const Index3& voxel) const;
    double outsideDuct(const Line&, double from_m, double last_m, double step_m) const;

    const Plan& plan_;
    const Grid& grid_;
    Index3 corner_;  // of the region, in the patient's grid
    double half_voxel_m_ = 0.0;
};

}  // namespace stylet::patient
