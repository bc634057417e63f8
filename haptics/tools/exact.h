// The exact force along a straight path through a motionless patient, solved from border to border without
// steps or samples. Same rules as needle.h (model in Eqs. 1-8), in closed form between events.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/traversal.h"
#include "haptics/tools/needle.h"

namespace stylet::haptics {

// One segment of a straight path: `tissue` from `begin_m` (depth along the path) to the next segment.
struct Segment {
    double begin_m = 0.0;
    Tissue tissue = Tissue::air;
    std::uint8_t label = 0;
};

// Force as a function of depth: f = c2 x^2 + c1 x + c0 on [begin, end), x = depth - begin.
struct ForcePiece {
    double begin_m = 0.0, end_m = 0.0;
    double c0_n = 0.0, c1_n_per_m = 0.0, c2_n_per_m2 = 0.0;
    Tissue tissue = Tissue::air;
    Phase phase = Phase::pass;

    double at(double depth_m) const {  // clamped to the piece
        const double x = std::clamp(depth_m, begin_m, end_m) - begin_m;
        return (c2_n_per_m2 * x + c1_n_per_m) * x + c0_n;
    }
};

struct ExactEvent {
    NeedleEventKind kind = NeedleEventKind::border;
    Tissue tissue = Tissue::air;  // tissue entered
    std::uint8_t label = 0;
    double border_depth_m = 0.0;
    double depth_m = 0.0;  // of the tip at the event
    double force_before_n = 0.0, force_after_n = 0.0;
};

struct ExactForce {
    std::vector<ForcePiece> pieces;  // ascending, without gaps, from 0 to the path's length
    std::vector<ExactEvent> events;
    double at(double depth_m) const;  // force just after `depth_m`
};

// Samples the force just after each depth first_m + i * step_m. Bit-identical to at().
void sampleForce(const ExactForce&, double first_m, double step_m, std::span<double> force_n);

// Selects what starts a new segment: any change of label, or only a change of tissue. The force needs only
// changes of tissue. With `tissueChanges`, two segmentations that agree in their tissues give bit-identical
// forces. It also skips voxels that the path crosses for less than 1 nm, at an edge or a corner. Rounding
// decides which of these voxels a path between voxel centres touches. Only a membrane that separates the
// voxels before and behind is kept, as a segment of almost no length.
enum class Borders { labelChanges, tissueChanges };
// Finds the tissues along a straight path from entry to end in the reference frame and writes them to
// `segments`. Sets track flags as the needle would. `path` is scratch memory.
void segmentsAlong(const patient::TissueMap&, const Vec3& entry_m, const Vec3& end_m, VoxelPath& path,
                   std::vector<Segment>& segments);
// The same for an existing voxel walk of a path `length_m` long. The walk's grid must match the map's.
void segmentsAlong(const patient::TissueMap&, const std::vector<VoxelPath::Visit>& walk, double length_m,
                   Borders, std::vector<Segment>& segments);

// Bone is never punctured. `rises`: the force rises with the bone's stiffness to `max_force_n` and stays
// there to the end of the path, as in the simulation. `immediateMaximum`: the force is at its maximum at
// once, as in the paper; used by the study.
enum class Bone { rises, immediateMaximum };
// The needle starts in air. A path that begins in tissue meets the skin at depth 0.
ExactForce solveExact(const patient::TissueTable&, const std::vector<Segment>&, double length_m,
                      const NeedleSettings&, Bone = Bone::rises);

// Solves many paths through one patient. Allocates only while its buffers grow. One solver per thread.
class ExactSolver {
  public:
    // The map must outlive the solver.
    ExactSolver(const patient::TissueMap& map, const NeedleSettings& settings, Bone bone = Bone::rises)
        : map_(map), settings_(settings), bone_(bone) {}
    // From entry to end in the reference frame. The result is valid until the next call.
    const ExactForce& solve(const Vec3& entry_m, const Vec3& end_m);
    const ExactForce& solve(const std::vector<VoxelPath::Visit>& walk, double length_m, Borders);
    // Segments of the last solution. The first is air.
    const std::vector<Segment>& segments() const { return segments_; }

  private:
    const ExactForce& solveSegments(double length_m);

    const patient::TissueMap& map_;
    NeedleSettings settings_;
    Bone bone_;
    VoxelPath path_;
    std::vector<Segment> segments_, cuts_;
    ExactForce force_;
};

}  // namespace stylet::haptics
