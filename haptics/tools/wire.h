// The guide wire beyond the tip of the needle: a chain of nodes with a floppy end that follows the lumen of
// the ducts, and its force on the hand along the needle. packaging/guide/drainage.md has the formulas.
//
// The chain is solved by position-based dynamics (Mueller et al., "Position Based Dynamics", VRIPHYS 2006)
// with a fixed number of iterations; the lengths are solved directly, as one tridiagonal system, after Deul,
// Kugelstadt, Weiler and Bender, "Direct Position-Based Solver for Stiff Rods", Computer Graphics Forum 37,
// 2018. All positions are in the reference frame, so the wire moves with the tissue. The force does not
// follow from the solver. It has a closed form: friction with the capstan equation, Euler's column load.
#pragma once

#include <array>
#include <limits>

#include "base/hash.h"
#include "base/realtime.h"
#include "patient/patient.h"

namespace stylet::haptics {

inline constexpr int kMaxWireNodes = 80;
inline constexpr double kWireRest_m = 0.002;  // length of a segment
inline constexpr double kMaxWire_m = kMaxWireNodes * kWireRest_m;

// The default is assets/instruments/guide-wire.toml. No source gives all of these for one wire: stiffness,
// friction and blunt force are our estimates.
struct WireSettings {
    double outer_m = 0.89 / 1e3;         // as the file's millimetres are converted
    double tip_length_m = 0.030;         // floppy end
    double tip_stiffness_n_m2 = 5e-6;    // E I of the floppy end
    double shaft_stiffness_n_m2 = 5e-5;  // E I of the rest
    double grip_n_per_m = 500.0;         // spring between hand and wire
    double bore_friction_n = 0.05;       // of the wire in the needle
    double drag_n_per_m = 0.5;           // friction per length in the duct
    double friction = 0.1;               // Coulomb coefficient at bends (capstan equation)
    double tip_friction = 0.4;           // of the tip that meets a wall
    double blunt_n = 2.0;                // force at which the tip enters solid tissue
    double attenuation_per_m = 652.0;    // X-ray
    double radius_m() const noexcept { return 0.5 * outer_m; }
};
template <typename Settings, typename Visit>
void visitWireNumbers(Settings& s, const Visit& visit) {
    visit(s.outer_m), visit(s.tip_length_m), visit(s.tip_stiffness_n_m2), visit(s.shaft_stiffness_n_m2);
    visit(s.grip_n_per_m), visit(s.bore_friction_n), visit(s.drag_n_per_m), visit(s.friction);
    visit(s.tip_friction), visit(s.blunt_n), visit(s.attenuation_per_m);
}

// The opening from which the wire emerges (the needle's tip) and its direction. Reference frame.
struct WireBase {
    Vec3 at_m{0.0}, axis{0.0, 0.0, 1.0};
};

struct WireState {
    int count = 0;
    // Nodes from the tip back to the base, kWireRest_m apart; the last is nearer to the base.
    std::array<Vec3, kMaxWireNodes> nodes_m{};
    double fed_m = 0.0;        // length beyond the base; < 0: the tip is behind it
    double extension_m = 0.0;  // of the grip's spring; > 0: the hand pushes
    bool in_lumen = false;     // the wire has reached the lumen of a duct
    double solid_m = 0.0;      // length beyond the base at which it reached the lumen
    // Length beyond the base at which the tip pierced the duct's wall; infinite: it has not.
    double pierced_m = std::numeric_limits<double>::infinity();
    bool buckled = false;   // the wire does not advance, and bends where the hand pushes on
    double turn_rad = 0.0;  // sum of all bends
    double bend_n = 0.0;    // force that the bends oppose to feeding
};

// Tip of the wire.
Vec3 wireTip(const WireState&, const WireBase&) noexcept STYLET_NONBLOCKING;
// Largest force that the floppy column beyond the base carries: Euler, one end clamped, the other pinned. The
// column is at most as long as the floppy end, because the wall of the duct does not support it.
double columnLoad_n(const WireSettings&, double fed_m) noexcept STYLET_NONBLOCKING;
// Friction of the wire in the needle and in the duct (capstan equation).
double wireFriction_n(const WireSettings&, double fed_m, double turn_rad) noexcept STYLET_NONBLOCKING;

// Haptics thread. noexcept, no allocation. One tick in which the hand moves by `moved_m` along the needle
// (> 0: into the body), relative to the tissue. Returns the force that resists, > 0 against insertion. At
// rest the chain is not solved.
double stepWire(WireState&, const WireSettings&, const patient::DuctSpace&, const WireBase&,
                double moved_m) noexcept STYLET_NONBLOCKING;
// Energy in the spring of the grip. The energy of the bent wire does not return to the hand.
double wireEnergy_j(const WireState&, const WireSettings&) noexcept STYLET_NONBLOCKING;
void hashWire(StateHash&, const WireState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
