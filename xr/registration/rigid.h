// Pose alignment of two point sets, and the expected error at other targets.
// Based on S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
// IEEE PAMI 13 (1991), and J. M. Fitzpatrick, J. B. West, C. R. Maurer, Predicting error in rigid-body
// point-based registration, IEEE TMI 17 (1998).
#pragma once

#include <array>
#include <span>

#include "xr/registration/geometry.h"

namespace stylet::xr::registration {

struct RigidFit {
    Pose a_from_b;
    double scale = 1.0;  // p_a = a_from_b * (scale * p_b)
    double fre_m = 0.0;  // root mean square residual
};

// Umeyama's closed form (eqs. 40 to 43). Refuses fewer than three points, sets of different size,
// non-finite numbers, and points on a line.
Result<RigidFit> fitRigid(std::span<const Vec3> a_m, std::span<const Vec3> b_m, bool with_scale);

// Spread of points about their centre: RMS distances along the principal axes, largest first.
struct Spread {
    Vec3 centre_m{0.0};
    std::array<Vec3, 3> axes;
    Vec3 sizes_m{0.0};
};
Spread computeSpread(std::span<const Vec3> points_m);

// Expected RMS error of a rigid fit of these points at a target (Fitzpatrick et al.):
// TRE^2 = FLE^2 / N * (1 + 1/3 sum_k d_k^2 / f_k^2).
// d_k is the distance of the target from principal axis k, f_k the RMS distance of the points from it.
// `fle_m` is the RMS length of a point's error: sqrt(3) times its standard deviation per axis. Infinite for
// points on a line.
double expectedTre_m(std::span<const Vec3> points_m, double fle_m, const Vec3& target_m);
// Expected RMS residual of a fit of N points: FRE^2 = (1 - 2/N) FLE^2.
double expectedFre_m(int points, double fle_m);

// Working volume of the tip.
struct Cube {
    Vec3 centre_m{0.0};
    double half_m = 0.04;
};
struct CubeError {
    double mean_m = 0.0, worst_m = 0.0;  // RMS over the cube, and at its worst corner
};
CubeError expectedTreInCube(const Cube&, std::span<const Vec3> points_m, double fle_m);

}  // namespace stylet::xr::registration
