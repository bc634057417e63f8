// Internal: rates one path by the four criteria. Based on Mastmeyer et al. 2017, Eq. 9.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/traversal.h"
#include "patient/package/tissue_map.h"
#include "patient/planning/planning_region.h"

namespace stylet::patient {

inline constexpr double kFullClearance_m = 0.010;  // C3 = 1
inline constexpr double kFullChord_m = 0.010;      // C4 = 1
inline constexpr double kCorner_m = 1e-9;          // a shorter stretch in a voxel only touches its corner

// toScore() computes C3 and C4 from a length. pathQuality() computes Q from both scores.
double toScore(double metres, double full_m) noexcept;
double pathQuality(double clearance_score, double target_score) noexcept;

// True in the breathing state of the CT, in which a straight line in the deformed patient is also straight in
// the reference.
bool isReferenceBreath(const Patient&, const Surrogate& breath);

// Shared by all threads, read-only.
struct Plan {
    const Patient& patient;
    const PlanSettings& settings;
    const PlanRegion& region;
    const TissueMap& map;
};

inline constexpr double kChord_m = 0.001;  // length of the pieces of a line bent by breathing

// Visits the voxels of the REFERENCE along straight lines in the deformed patient. Use one per thread.
class Walker {
  public:
    Walker(const Patient& patient, const Surrogate& breath)
        : motion_(patient.package().motion),
          grid_(patient.grid()),
          breath_(breath),
          straight_(isReferenceBreath(patient, breath)) {}

    // Calls visit(voxel visit, begin_m, end_m) along a + s * direction until it returns false.
    template <typename Visit>
    void walk(const Vec3& a, const Vec3& direction, double length_m, const Visit& visit) {
        bool going = true;
        const auto walkStretch = [&](double begin, double end) {
            const int pieces =
                straight_ ? 1 : std::max(1, int(std::ceil((end - begin) * length_m / kChord_m)));
            const double begin_m = begin * length_m, piece_m = (end - begin) * length_m / pieces;
            Vec3 from = referenceFromDeformed(motion_, breath_, a + direction * begin_m);
            for (int i = 0; i < pieces && going; ++i) {
                const double at_m = begin_m + piece_m * i;
                const Vec3 to = referenceFromDeformed(motion_, breath_, a + direction * (at_m + piece_m));
                const std::vector<VoxelPath::Visit>& visits = path_.traverse(grid_, from, to);
                for (std::size_t v = 0; v < visits.size() && going; ++v) {
                    const double share = v + 1 < visits.size() ? visits[v + 1].begin : 1.0;
                    going = visit(visits[v], at_m + piece_m * visits[v].begin, at_m + piece_m * share);
                }
                from = to;
            }
        };
        if (straight_)
            walkStretch(0.0, 1.0);
        else
            forEachStretch(sideChanges(motion_, breath_, a, a + direction * length_m), walkStretch);
    }

  private:
    const MotionModel& motion_;
    const Grid& grid_;
    Surrogate breath_;
    bool straight_;
    VoxelPath path_;
};

enum class Verdict { accepted, blocked, tooLong, poor };

// Use one per thread.
class PathEvaluator {
  public:
    // The plan must outlive it.
    explicit PathEvaluator(const Plan&);
    // Fills clearance score, target score and quality of a path whose ends are set.
    Verdict evaluate(PlannedPath&);

  private:
    struct Duct {
        double wall_m = 0.0;  // depth of the duct's near wall along the path
        double chord_m = 0.0;
    };
    struct Surroundings {
        double clearance_m = kFullClearance_m;
        bool between_ribs = false;  // also true if the flank has no ribs
        bool uncertain = false;     // too close to a risk structure with an uncertain border
    };

    std::optional<Duct> traverse(const Vec3& entry_m, const Vec3& direction, double length_m);
    bool isFreeBeside(const PlannedPath&, const Vec3& direction);
    bool isFreeOutside(const PlannedPath&, const Vec3& direction);
    Surroundings findSurroundings(const PlannedPath&, double wall_m);

    const TissueMap& map_;
    const PlanSettings& settings_;
    const PlanRegion& region_;
    Walker walker_;
    VoxelPath around_;
};

}  // namespace stylet::patient
