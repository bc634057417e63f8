// The needle down one planned path in two patients at once, by one force model: what it meets and feels in
// each. Based on Mastmeyer et al. 2017, "Path Planning and Needle Steering".
#pragma once

#include <optional>
#include <vector>

#include "app/study/pair.h"
#include "haptics/haptics.h"

namespace stylet::study {

inline constexpr double kTick_s = 0.001;

struct SteeringSettings {
    int samples = 1000;            // a path, at least
    double max_spacing_m = 90e-6;  // of them
    double before_m = 0.005;       // the needle comes from the air: a skin may lie before the planned one
    double beyond_m = 0.010;       // borders are looked for this far behind the target
    haptics::NeedleSettings needle;
    // The patients breathe, and the hand steers on through the room at this speed. Off, as in the paper: both
    // stand still in the breath of the CT.
    bool breathing = false;
    double speed_m_s = 0.020;
};

// What one patient does to the needle. Depths count from where the walk begins, before_m before the entry.
struct Felt {
    const std::vector<haptics::Segment>* segments = nullptr;  // to the walk's end; the first is air
    // Closed form to the walk's end; while the patients breathe its pieces are empty and its events those of
    // the sampled needle.
    const haptics::ExactForce* force = nullptr;
    std::vector<double> samples_n;
};

struct Steered {
    double entry_m = 0.0;                // of the planned skin voxel's centre
    double begin_m = 0.0, end_m = 0.0;   // from where either patient is first touched to the target
    double first_m = 0.0, step_m = 0.0;  // of the samples: each in the middle of its part of the way
    Felt full, partial;
};

// One a thread; keeps its buffers from path to path.
class Steering {
  public:
    // The pair must outlive it.
    Steering(const PreparedPair&, const SteeringSettings&);
    // Nothing where neither patient is met before the target. Stands until the next call.
    const Steered* steer(const patient::PlannedPath&);

  private:
    void lookAhead(const patient::PlannedPath&);
    void walkBreathing(const patient::PlannedPath&, const patient::Patient&, haptics::ExactForce&,
                       std::vector<double>& samples_n) const;

    const PreparedPair& pair_;
    SteeringSettings settings_;
    patient::VoxelPath path_;
    haptics::ExactSolver full_, partial_;
    haptics::ExactForce breathing_full_, breathing_partial_;
    std::vector<patient::Surrogate> breath_;  // at each tick since the walk's begin, the longest walk's
    Steered steered_;
};

}  // namespace stylet::study
