// The scalpel: a light touch on the skin until its point goes in, then a blade that is held by what it cuts.
// It opens an incision (incision.h) that the needle passes without the skin's threshold.
#pragma once

#include "haptics/incision.h"
#include "haptics/tool.h"
#include "haptics/touch.h"

namespace stylet::haptics {

// Tool frame: the blade's point at the origin, +z along the handle out of the body, +x where the edge looks.
// Forces are our choice: a blade goes in more lightly than a needle (skin's row: 0.7 N).
struct ScalpelSettings {
    double stiffness_n_per_m = 800.0;  // of the spring between the hand and the blade's proxy: skin's row
    double cut_force_n = 0.4;          // along the skin's normal, where it is whole
    double friction = 0.3;             // of the blade sliding on whole skin
    // Inside, what moves the proxy along each of the blade's axes.
    double deeper_n = 0.3, along_edge_n = 0.2, across_blade_n = 0.8;
    double width_per_depth = 0.5;  // of a No. 11 blade: a stab 6 mm deep opens 3 mm
    double open_reach_m = 0.0015;  // beside an incision the skin is open
};

struct ScalpelState {
    bool touching = false, cutting = false;
    int incision = -1;  // the one being cut; none where the list is full
    Vec3 proxy_reference_m{0.0};
    Vec3 skin_reference_m{0.0};  // under the point
    Vec3 outward{0.0};
    double depth_m = 0.0;  // of the point, >= 0
    patient::Surrogate breath;
    bool primed = false;
};

// Haptics thread. noexcept, no allocation. One tick; a cut is an event of the force. An incision is extended
// to wherever the blade has been, at its ends: it stays straight.
ToolForce stepScalpel(ScalpelState&, Incisions&, const ScalpelSettings&, const TouchMap&,
                      const patient::MotionModel&, const Pose& patient_from_tool,
                      const patient::Surrogate&) noexcept STYLET_NONBLOCKING;
void hashScalpel(patient::StateHash&, const ScalpelState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
