// The scalpel. Its point slides on the skin until the force is large enough to pierce the skin. Inside the
// body, the tissue resists the blade until it cuts further. It opens an incision (incision.h), which the
// needle passes without the skin's puncture threshold.
#pragma once

#include "base/hash.h"
#include "haptics/tools/incision.h"
#include "haptics/tools/tool.h"
#include "haptics/tools/touch.h"

namespace stylet::haptics {

// Tool frame: the blade's point at the origin, +z along the handle out of the body, +x in the direction of
// the cutting edge. The forces are our choice: a blade pierces the skin at a lower force than a needle
// (skin's row: 0.7 N).
struct ScalpelSettings {
    double stiffness_n_per_m = 800.0;  // of the spring between stylus and blade proxy: skin's row
    double cut_force_n = 0.4;          // along the skin normal, on intact skin
    double friction = 0.3;             // of the blade sliding on intact skin
    // Inside the body: the force that moves the proxy along each of the blade's axes.
    double deeper_n = 0.3, along_edge_n = 0.2, across_blade_n = 0.8;
    double width_per_depth = 0.5;  // No. 11 blade: a stab 6 mm deep opens 3 mm
    double open_reach_m = 0.0015;  // within this distance of an incision the skin is open
};

struct ScalpelState {
    bool touching = false, cutting = false;
    int incision = -1;  // index of the incision being cut, or -1; also -1 when the list was full
    Vec3 proxy_reference_m{0.0};
    Vec3 skin_reference_m{0.0};  // below the blade's point
    Vec3 outward{0.0};
    double depth_m = 0.0;  // of the blade's point, >= 0
    patient::Surrogate breath;
    bool primed = false;
};

// Haptics thread. noexcept, no allocation. One tick. Piercing the skin sets ToolForce::event. The incision's
// ends are extended so that it reaches every position of the blade; it stays straight.
ToolForce stepScalpel(ScalpelState&, Incisions&, const ScalpelSettings&, const BreathingSkin&,
                      const Pose& patient_from_tool) noexcept STYLET_NONBLOCKING;
void hashScalpel(StateHash&, const ScalpelState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
