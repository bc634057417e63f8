// A column of layers and a hand that pushes a needle along it.
#pragma once

#include <utility>
#include <vector>

#include "haptics/haptics.h"

namespace stylet::test {

using Layers = std::vector<std::pair<patient::Tissue, double>>;

// Layers along +x from x = 0, 80 mm wide, air around; thicknesses in whole voxels of `pitch_m`.
patient::Package makeColumn(const Layers&, double pitch_m = 0.0001);

// The same layers in n x n voxels of `pitch_m` across, to paint into.
patient::Package widen(const patient::Package& column, int n, double pitch_m);

// The cavity of a simple breath: everything within 0.3 m of the origin moves by `travel_m` along z at full
// inhale.
void letBreathe(patient::Package&, double travel_m);

// Moves the tip along +x (or as told) and keeps every event.
struct Hand {
    explicit Hand(const patient::Patient& p) : patient(p) {}

    double force() const { return state.force_n; }
    // One step.
    void to(const Vec3& tip_m);
    void to(double x_m) { to({x_m, 0.0003, 0.0002}); }
    // Steps of at most `step_m`, the last one shorter.
    void sweep(double x_m, double step_m = 0.00009);
    // The events of one kind.
    std::vector<haptics::NeedleEvent> of(haptics::NeedleEventKind) const;

    const patient::Patient& patient;
    haptics::NeedleSettings settings;
    haptics::Incisions incisions;
    haptics::NeedleState state;
    haptics::ToolForce last;
    Vec3 axis{1.0, 0.0, 0.0};
    patient::Surrogate breath;
    std::vector<haptics::NeedleEvent> events;
};

}  // namespace stylet::test
