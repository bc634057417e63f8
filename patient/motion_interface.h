// The surface on which the two sides of a motion slide: made tangential, and measured.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "patient/motion.h"

namespace stylet::patient {

// C1 from 0 at `from` to 1 at `to`; `from` may be the greater.
inline double smoothStep(double from, double to, double x) noexcept {
    const double s = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

// Points of the surface (level 0), at least one in every cell that it crosses, and its unit normals there.
struct SurfacePoint {
    Vec3 reference_m{0.0}, normal{0.0};
};
std::vector<SurfacePoint> cavitySurface(const MotionModel&);

// Raises the level until it is at least `margin_m` at every one of `points_m`: what lies there is outside.
// Raised far along z and little across, so that the surface passes rib after rib smoothly, as it slides.
void keepOutside(MotionModel&, const std::vector<Vec3>& points_m, double margin_m);

// Makes `slide` tangential: takes the part along the level's gradient from every node near the surface and
// outside, none of it from `depth_m` inside, ends the field a few nodes outside, and takes what interpolation
// leaves at the surface from the nodes around it. For templates and fits alike; call it last.
void makeTangential(MotionModel&, double depth_m = 0.035);

// How far the inside's edge, moved, lies from the outside's: a gap where the inside draws back, an overlap
// where it reaches into the outside.
struct InterfaceError {
    std::size_t points = 0;
    double mean_m = 0.0, p99_m = 0.0, worst_gap_m = 0.0, worst_overlap_m = 0.0;
    double mean_slip_m = 0.0, most_slip_m = 0.0;  // of the two sides past each other
};
InterfaceError measureInterface(const MotionModel&, const Surrogate& now);

// The four ends of what v and v' are clamped to, and the worst of each number over them.
std::array<Surrogate, 4> farthestBreaths(const MotionModel&);
InterfaceError worstInterface(const MotionModel&);

// The least determinant of the Jacobian over two points of every cell and the farthest breaths, were the
// motion `times` as far.
double leastJacobian(const MotionModel&, double times);

}  // namespace stylet::patient
