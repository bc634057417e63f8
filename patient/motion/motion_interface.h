// The surface along which the two sides of a motion slide: makes the sliding tangential and measures it.
#pragma once

#include <cstddef>
#include <vector>

#include "patient/motion/motion.h"

namespace stylet::patient {

// cavitySurface() returns points on the surface (level 0) with unit normals, at least one in every cell that
// the surface crosses.
struct SurfacePoint {
    Vec3 reference_m{0.0}, normal{0.0};
};
std::vector<SurfacePoint> cavitySurface(const MotionModel&);

// Raises the level to at least `margin_m` at each of `points_m`, so that these points are outside. The change
// extends far along z and little across it. So the surface runs smoothly past the ribs in the direction of
// sliding.
void raiseLevelAt(MotionModel&, const std::vector<Vec3>& points_m, double margin_m);

// Makes `slide` tangential to the surface. Removes the component along the level's gradient: fully at
// nodes near the surface and outside, not at all deeper than `depth_m` inside. Fades the field to zero a
// few nodes outside. Then removes the normal component that interpolation leaves at the surface. For
// templates and fits; call it last.
void makeTangential(MotionModel&, double depth_m = 0.035);

// Mismatch of the two sides after the motion: a gap where the inside stays behind the outside's edge, an
// overlap where it crosses that edge.
struct InterfaceError {
    std::size_t points = 0;
    double mean_m = 0.0, p99_m = 0.0, worst_gap_m = 0.0, worst_overlap_m = 0.0;
    double mean_slip_m = 0.0, max_slip_m = 0.0;  // sliding of the two sides past each other
};
InterfaceError measureInterface(const MotionModel&, const Surrogate& now);

// The four corners of the clamping ranges of v and v'. worstInterface() returns the maximum of each error
// over them.
std::array<Surrogate, 4> cornerBreaths(const MotionModel&);
InterfaceError worstInterface(const MotionModel&);

// Smallest determinant of the Jacobian in the most extreme breathing states, with the motion scaled by
// `scale`. Samples two points per cell.
double minJacobian(const MotionModel&, double scale);

}  // namespace stylet::patient
