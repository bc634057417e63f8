// The fascia as the paper has it: one smooth tube through the inner rib cage and outside the organs, whose
// radius about an upright axis is a tensor B-spline r(phi, h), periodic in phi. Its control points are a text
// that a person may edit.
// Based on Mastmeyer, Wilms and Handels, "Interpatient respiratory motion model transfer for virtual reality
// simulations of liver punctures", J. WSCG 25, 2017 (the surface); de Boor, "A Practical Guide to Splines",
// 1978 (uniform cubic basis).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/modeller/import_fascia.h"

namespace stylet::modeller {

struct FasciaSpline {
    patient::Vec3 axis_m{0.0};                 // x and y; the axis is upright
    double h_begin_m = 0.0, h_step_m = 0.015;  // knots: h_begin, h_begin + h_step, ...
    int around = 36, levels = 0;               // control points a turn, at least 4; rows, at least 4
    std::vector<double> control_m;             // [row * around + k], k at angle 2 pi k / around from +x to +y

    // Row n weighs most at h_begin + (n - 1) h_step. Constant above and below all knots.
    double radiusAt(double phi, double h_m) const;
};

// Least squares through what shows the wall (bones, lungs, the belly wall's muscle), with second differences
// kept small; where a bone or an organ is in the way the fit is drawn past it.
FasciaSpline fitFascia(const FasciaInput&);

// What the tube encloses, without the bones, and with organs that stand out of it.
Mask insideFascia(const FasciaSpline&, const FasciaInput&);

// The surface, one voxel thick, 6-separating; it gives way to bones and, but at those, to organs.
Mask fasciaVoxels(const FasciaSpline&, const FasciaInput&);

// Text: `stylet-fascia 1`, then `axis_mm`, `h_begin_mm`, `h_step_mm`, `around`, `levels`, then `row 0` to
// `row levels-1` with the radii in mm; # begins a comment.
std::string writeFascia(const FasciaSpline&);
// `file` is only named. Throws ImportError: FILE: line N: FIELD reason.
FasciaSpline parseFascia(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet::modeller
