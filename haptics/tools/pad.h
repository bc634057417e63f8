// A pad of points pressed on the skin, shared by the finger and the probe. Each point has its own proxy.
// Normal to the skin each point is a spring given by the layers under it (touch.h). Along the skin its
// proxy sticks until friction is exceeded and then slips after the point. Sticking proxies are points in
// the reference frame, so they move with breathing.
#pragma once

#include <array>
#include <cstdint>

#include "base/hash.h"
#include "haptics/tools/tool.h"
#include "haptics/tools/touch.h"

namespace stylet::haptics {

inline constexpr int kMaxPadPoints = 32;

// Tool frame: tip at the origin, +z away from the patient, as for the needle (toward the user's hand).
struct Pad {
    int count = 0;
    double point_area_m2 = 0.0;  // area per point
    double reach_m = 0.0;        // distance of the farthest point from the tip
    std::array<Vec3, kMaxPadPoints> points_m{};
};
// A round cap on a sphere of radius `curvature_m`: `count` points of equal area in sunflower (Fibonacci)
// order.
Pad roundPad(int count, double radius_m, double curvature_m) noexcept;
// A curved bar along x: columns x rows points of equal area on a cylinder of radius `curvature_m` about y.
Pad barPad(int columns, int rows, double length_m, double width_m, double curvature_m) noexcept;

// Stiffnesses of the whole pad. `max_stiffness_n_per_m` bounds the normal tangent stiffness everywhere.
// On a reference patient the stiffness in the other directions was measured to be lower (1,560 N/m into the
// flank, 1,430 along it, including rib edges). Sticking proxies add `shear_n_per_m`.
struct PadSettings {
    double max_stiffness_n_per_m = 2000.0;  // bone's row of the force table
    double shear_n_per_m = 300.0;           // of the proxies while they stick
    double friction = 0.5;                  // Coulomb friction coefficient
};

struct PadState {
    std::uint32_t touching = 0;  // one bit per point
    std::array<Vec3, kMaxPadPoints> proxy_reference_m{};
    Vec3 skin_reference_m{0.0};  // the tip's foot point on the skin
    Vec3 outward{0.0};           // unit skin normal there, deformed patient
    double depth_m = 0.0;        // depth of the tip under the skin, >= 0
    patient::Surrogate breath;   // of the last step
    bool primed = false;
};

struct PadContact {
    ToolForce force;
    int touching = 0, slipping = 0;  // points
    double normal_n = 0.0;           // sum of the normal forces of all points
    double max_depth_m = 0.0;
};

// Haptics thread. noexcept, no allocation. One tick with the pad at `patient_from_tool` in the deformed
// patient. `energy_j` is the exact energy of the springs; without slip it equals the work put in.
PadContact stepPad(PadState&, const Pad&, const PadSettings&, const BreathingSkin&,
                   const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING;
void hashPad(StateHash&, const PadState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
