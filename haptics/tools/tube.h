// A dilator or drain that slides over the guide wire: tissue resists its taper and its shaft. Without a wire
// to follow, its blunt end does not advance. packaging/guide/drainage.md has the formulas.
#pragma once

#include <span>

#include "base/hash.h"
#include "base/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

// The defaults are those of assets/instruments/dilator.toml.
struct TubeSettings {
    double outer_m = 2.67 / 1e3, inner_m = 0.97 / 1e3;  // as the file's millimetres are converted
    double taper_m = 0.020;             // length over which the end widens to the outer diameter
    double stiffness_n_per_m = 1000.0;  // spring between hand and tube
    double blunt_n = 6.0;               // force at which the hand slips on a tube that meets tissue bluntly
    double pigtail_m = 0.0;             // diameter of the loop at a drain's end; 0: straight
    double attenuation_per_m = 21.8;    // X-ray
};
inline constexpr TubeSettings kDrainDefaults{
    .outer_m = 0.00283, .inner_m = 0.0017, .taper_m = 0.010, .pigtail_m = 0.010, .attenuation_per_m = 150.0};
template <typename Settings, typename Visit>
void visitTubeNumbers(Settings& s, const Visit& visit) {
    visit(s.outer_m), visit(s.inner_m), visit(s.taper_m), visit(s.stiffness_n_per_m);
    visit(s.blunt_n), visit(s.pigtail_m), visit(s.attenuation_per_m);
}

// The path from the skin that the tube follows: points in the reference frame, the first at the skin.
// `length_m` of it are open to the tube; behind that there is no wire.
struct TubePath {
    std::span<const Vec3> points_m;
    double length_m = 0.0;
};
// Point at a depth along the path; continued straight at both ends. At least two points.
Vec3 pointAt(const TubePath&, double depth_m) noexcept STYLET_NONBLOCKING;
double pathLength_m(std::span<const Vec3> points_m) noexcept STYLET_NONBLOCKING;

struct TubeState {
    double depth_m = 0.0;      // of the tip along the path; < 0 outside the body
    double extension_m = 0.0;  // of the spring to the hand; > 0: the hand pushes
    patient::Tissue tissue = patient::Tissue::air;
    bool stopped = false;  // its end meets tissue bluntly
};

// The opening that tools have made before: its diameter down to a depth, and that of the needle behind it.
struct Opening {
    double dilated_m = 0.0;   // depth
    double diameter_m = 0.0;  // down to there
    double needle_m = 0.0015;
    double at(double depth_m) const noexcept { return depth_m <= dilated_m ? diameter_m : needle_m; }
};

// Resistance at a depth, N: friction at the tip's tissue, and the force that widens the opening to the taper.
struct TubeResistance {
    double friction_n = 0.0, widening_n = 0.0;
};
TubeResistance tubeResistance(const TubeSettings&, const TubePath&, const Opening&, const patient::Patient&,
                              double depth_m) noexcept STYLET_NONBLOCKING;

// Haptics thread. noexcept, no allocation. One tick in which the hand moves by `moved_m` along the path (> 0:
// into the body), relative to the tissue. Returns the force that resists, > 0 against insertion.
double stepTube(TubeState&, const TubeSettings&, const TubePath&, const Opening&, const patient::Patient&,
                double moved_m) noexcept STYLET_NONBLOCKING;
double tubeEnergy_j(const TubeState&, const TubeSettings&) noexcept STYLET_NONBLOCKING;
void hashTube(StateHash&, const TubeState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
