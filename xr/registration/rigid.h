// Two sets of points laid onto one another, and how well that holds elsewhere.
// Based on S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
// IEEE PAMI 13 (1991), and J. M. Fitzpatrick, J. B. West, C. R. Maurer, Predicting error in rigid-body
// point-based registration, IEEE TMI 17 (1998).
#pragma once

#include <array>
#include <span>

#include "xr/registration/geometry.h"

namespace stylet::xr::registration {

struct RigidFit {
    Rigid a_from_b;
    double scale = 1.0;  // p_a = a_from_b * (scale * p_b)
    double fre_m = 0.0;  // root mean square residual
};

// Umeyama's closed form (eqs. 40 to 43). Refuses fewer than three points, unequal numbers, numbers that are
// not finite, and points on a line.
Answer<RigidFit> fitRigid(std::span<const Vec3> a_m, std::span<const Vec3> b_m, bool with_scale);

// How the points are spread about their centre: root mean square distances along their principal axes,
// the longest first.
struct Spread {
    Vec3 centre_m{0.0};
    std::array<Vec3, 3> axes;
    Vec3 sizes_m{0.0};
};
Spread spreadOf(std::span<const Vec3> points_m);

// Expected error at a target of a rigid fit over these points, as a root mean square (Fitzpatrick et al.):
// TRE^2 = FLE^2 / N * (1 + 1/3 sum_k d_k^2 / f_k^2), d_k and f_k the distances of target and points from
// principal axis k. `fle_m` is the root mean square length of a point's error: sqrt(3) times its standard
// deviation along an axis. Infinite for points on a line.
double expectedTre_m(std::span<const Vec3> points_m, double fle_m, const Vec3& target_m);
// What the residuals of a fit over n points are expected to be: FRE^2 = (1 - 2/N) FLE^2.
double expectedFre_m(int points, double fle_m);

// A cube that the tip works in.
struct Cube {
    Vec3 centre_m{0.0};
    double half_m = 0.04;
};
struct CubeError {
    double mean_m = 0.0, worst_m = 0.0;  // root mean square over the cube; at its worst corner
};
CubeError expectedTreIn(const Cube&, std::span<const Vec3> points_m, double fle_m);

}  // namespace stylet::xr::registration
