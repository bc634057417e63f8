// The fascia as in the paper: one smooth tube through the inner rib cage and outside the organs. Its radius
// about an upright axis is a tensor B-spline r(phi, h), periodic in phi. The control points are a text file
// that a person may edit.
// Based on Mastmeyer, Wilms and Handels, "Interpatient respiratory motion model transfer for virtual
// reality simulations of liver punctures", J. WSCG 25, 2017 (the surface); de Boor, "A Practical Guide to
// Splines", 1978 (uniform cubic basis).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/wall/body_wall.h"

namespace stylet::modeller {

struct FasciaSpline {
    Vec3 axis_m{0.0};                          // x and y; the axis is upright
    double h_begin_m = 0.0, h_step_m = 0.015;  // knots: h_begin, h_begin + h_step, ...
    int around = 36, levels = 0;               // control points per turn, at least 4; rows, at least 4
    std::vector<double> control_m;             // [row * around + k], k at angle 2 pi k / around from +x to +y

    // Row n has its largest weight at h_begin + (n - 1) h_step. Constant above and below all knots.
    double radiusAt(double phi, double h_m) const;
};

// Least-squares fit to the observed fascia (fascia_surface.h) with small second differences. Bones and organs
// push the surface away where the fit would cut them.
FasciaSpline fitFascia(const FasciaInput&);

// The organs without the voxels within 1.2 mm of their border: in voxels of 1 mm the outermost one, in voxels
// of more than 1.2 mm none. The border of an organ, drawn or found, is uncertain by that, and an organ that
// is too large would push the fascia outward: where they disagree, the wall's edge in the CT is more
// reliable.
Mask withoutRim(const Mask& organs);

// The volume inside the tube: without bones, and with organs that extend beyond it.
Mask insideFascia(const FasciaSpline&, const FasciaInput&);

// The surface of this volume, one voxel thick and 6-separating. It avoids bones, and it avoids organs except
// next to bones.
Mask fasciaVoxels(const Mask& inside, const FasciaInput&);

// The voxels of organs that are muscle, because the fascia lies where it does. Just outside the fascia, it is
// what the fascia cuts off from the organs' rims; pieces farther out are none of it. Within 1.5 mm behind the
// fascia, it is the diaphragm in front of liver and spleen, which is often too thin to be seen. In voxels of
// more than 1.5 mm there is none.
Mask muscleAtFascia(const Mask& organs, const Mask& liver_and_spleen, const Mask& inside, const Mask& fascia);

// Small pieces of the liver outside the fascia, where a needle would reach them without passing it. They come
// from a ragged border. Pieces of 0.5 ml or more are left out, and all of them if they are more than 2 ml:
// `check` reports those.
Mask strayLiver(const Mask& liver, const Mask& inside);

// Text format: `stylet-fascia 1`, then `axis_mm`, `h_begin_mm`, `h_step_mm`, `around`, `levels`, then `row
// 0` to `row levels-1` with the radii in mm. # starts a comment.
std::string writeFascia(const FasciaSpline&);
// `file` is only used in messages. Throws DataError: FILE: line N: FIELD reason.
FasciaSpline parseFascia(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet::modeller
