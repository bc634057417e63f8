// Steers a needle along one planned path in two patients at once, with one force model, and records the
// events and forces in each. Based on Mastmeyer et al. 2017, "Path Planning and Needle Steering".
#pragma once

#include <optional>
#include <vector>

#include "app/study/pair.h"
#include "base/traversal.h"
#include "haptics/haptics.h"

namespace stylet::study {

inline constexpr double kTick_s = 0.001;

struct SteeringSettings {
    int samples = 1000;            // least number per path
    double max_spacing_m = 90e-6;  // of the samples
    double before_m = 0.005;       // start in air: a patient's skin may lie before the planned entry
    double beyond_m = 0.010;       // borders are searched this far behind the target
    haptics::NeedleSettings needle;
    // The patients breathe, and the needle advances through the room at this constant speed. Off, as in the
    // paper: both patients stay at the breathing state of the CT.
    bool breathing = false;
    double speed_m_s = 0.020;
};

// Force and events in one patient. Depths count from the start of the walk, before_m before the entry.
struct PatientForces {
    const std::vector<haptics::Segment>* segments = nullptr;  // up to the end of the walk; the first is air
    // Closed form up to the end of the walk. If the patients breathe, its pieces are empty and its events
    // are those of the sampled needle.
    const haptics::ExactForce* force = nullptr;
    std::vector<double> samples_n;
};

struct SteeringResult {
    double entry_m = 0.0;                // depth of the planned skin voxel's centre
    double begin_m = 0.0, end_m = 0.0;   // from the first touch of either patient to the target
    double first_m = 0.0, step_m = 0.0;  // samples, each in the middle of its interval
    PatientForces full, partial;
};

// One per thread. Reuses its buffers from path to path.
class Steering {
  public:
    // The pair must outlive it.
    Steering(const PreparedPair&, const SteeringSettings&);
    // Returns null if the needle touches neither patient before the target. Valid until the next call.
    const SteeringResult* steer(const patient::PlannedPath&);

  private:
    void solveStatic(const patient::PlannedPath&);
    void walkBreathing(const patient::PlannedPath&, const patient::Patient&, haptics::ExactForce&,
                       std::vector<double>& samples_n) const;

    const PreparedPair& pair_;
    SteeringSettings settings_;
    VoxelPath path_;
    haptics::ExactSolver full_, partial_;
    haptics::ExactForce breathing_full_, breathing_partial_;
    std::vector<patient::Surrogate> breath_;  // per tick, for the longest walk
    SteeringResult steered_;
};

}  // namespace stylet::study
