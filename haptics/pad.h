// A pad of points pressed on the skin, each with a proxy of its own: what finger and probe have in common.
// Normal to the skin each point is a spring of the layers under it (touch.h). Along the skin its proxy sticks
// until friction is exceeded, and then slips after it; held proxies are points of the reference, so the
// breath carries them.
#pragma once

#include <array>
#include <cstdint>

#include "haptics/tool.h"
#include "haptics/touch.h"

namespace stylet::haptics {

inline constexpr int kMaxPadPoints = 32;

// Tool frame: the tip at the origin, +z away from the patient (as the needle's, toward the hand).
struct Pad {
    int count = 0;
    double point_area_m2 = 0.0;  // each point's share
    double reach_m = 0.0;        // of the farthest point from the tip
    std::array<Vec3, kMaxPadPoints> points_m{};
};
// A round cap: `count` points of equal share in a sunflower's order, on a sphere of `curvature_m`.
Pad roundPad(int count, double radius_m, double curvature_m) noexcept;
// A curved bar along x: columns x rows of equal share on a cylinder of `curvature_m` about y.
Pad barPad(int columns, int rows, double length_m, double width_m, double curvature_m) noexcept;

// All stiffnesses of the whole pad. `stiffest_n_per_m` bounds the normal tangent anywhere; measured over a
// reference patient it bounds the others too (1,560 N/m into the flank, 1,430 along it, ribs' edges among
// them), to which sticking proxies add `shear_n_per_m`.
struct PadSettings {
    double stiffest_n_per_m = 2000.0;  // bone's row of the force table
    double shear_n_per_m = 300.0;      // of the proxies while they stick
    double friction = 0.5;             // Coulomb's coefficient
};

struct PadState {
    std::uint32_t touching = 0;  // a bit a point
    std::array<Vec3, kMaxPadPoints> proxy_reference_m{};
    Vec3 skin_reference_m{0.0};  // the tip's place on the skin
    Vec3 outward{0.0};           // there, unit, deformed patient
    double depth_m = 0.0;        // of the tip behind it, >= 0
    patient::Surrogate breath;   // of the last step
    bool primed = false;
};

struct PadContact {
    ToolForce force;
    int touching = 0, slipping = 0;  // points
    double normal_n = 0.0;           // sum of the points' pressures
    double deepest_m = 0.0;
};

// Haptics thread. noexcept, no allocation. One tick with the pad at `patient_from_tool` in the deformed
// patient. `energy_j` is the springs', exactly; without slip it is what was put in.
PadContact stepPad(PadState&, const Pad&, const PadSettings&, const TouchMap&, const patient::MotionModel&,
                   const Pose& patient_from_tool, const patient::Surrogate&) noexcept STYLET_NONBLOCKING;
void hashPad(patient::StateHash&, const PadState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
