// The exact force along a straight path through a still patient, border to border: no step, no samples.
// Same rules as needle.h (model in Eqs. 1-8), solved in closed form between events.
#pragma once

#include <span>
#include <vector>

#include "haptics/needle.h"

namespace stylet::haptics {

// A straight path as the needle meets it: tissue from `begin_m` (depth along the path) to the next border.
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
};

struct ExactEvent {
    NeedleEventKind kind = NeedleEventKind::border;
    Tissue tissue = Tissue::air;  // entered
    std::uint8_t label = 0;
    double border_depth_m = 0.0;
    double depth_m = 0.0;  // of the tip when it happened
    double force_before_n = 0.0, force_after_n = 0.0;
};

struct ExactForce {
    std::vector<ForcePiece> pieces;  // ascending, gap-free from 0 to the path's length
    std::vector<ExactEvent> events;
    double at(double depth_m) const;  // the force just after `depth_m`
};

// The force just after each of the depths first_m + i * step_m, as at() has it, bit for bit.
void sampleForce(const ExactForce&, double first_m, double step_m, std::span<double> force_n);

// What begins a segment: a change of label, or only one of tissue. To the force the latter is enough, and two
// segmentations that agree in tissues then come to the same bits. It leaves out corners of voxels, through
// which a path has less than 1 nm: on a path from voxel to voxel rounding says which of them it touches.
enum class Borders { ofLabels, ofTissues };
// The tissues along a straight path from entry to end in the reference (track flags as the needle would set
// them), written over `segments`; `path` is working space.
void segmentsAlong(const patient::TissueMap&, const Vec3& entry_m, const Vec3& end_m,
                   patient::VoxelPath& path, std::vector<Segment>& segments);
// The same over a walk that is there already, of a path `length_m` long through a grid like the map's.
void segmentsAlong(const patient::TissueMap&, const std::vector<patient::VoxelPath::Visit>& walk,
                   double length_m, Borders, std::vector<Segment>& segments);

// Bone is held for ever. Its force rises with its stiffness to `max_force_n` and stays there to the path's
// end, as for a hand; the study has that maximum at once, as the paper does.
enum class Bone { rises, maximumAtOnce };
// The needle comes from the air: a path that begins in tissue meets its skin at depth 0.
ExactForce solveExact(const patient::TissueTable&, const std::vector<Segment>&, double length_m,
                      const NeedleSettings&, Bone = Bone::rises);

// The same for path after path through one patient; allocates only while its buffers still grow. One a
// thread.
class ExactSolver {
  public:
    // The map must outlive the solver.
    ExactSolver(const patient::TissueMap& map, const NeedleSettings& settings, Bone bone = Bone::rises)
        : map_(map), settings_(settings), bone_(bone) {}
    // From entry to end in the reference. What is returned stands until the next call.
    const ExactForce& solve(const Vec3& entry_m, const Vec3& end_m);
    const ExactForce& solve(const std::vector<patient::VoxelPath::Visit>& walk, double length_m, Borders);
    // Of the last solution; the first is air.
    const std::vector<Segment>& segments() const { return segments_; }

  private:
    const ExactForce& solveSegments(double length_m);

    const patient::TissueMap& map_;
    NeedleSettings settings_;
    Bone bone_;
    patient::VoxelPath path_;
    std::vector<Segment> segments_, cuts_;
    ExactForce force_;
};

}  // namespace stylet::haptics
