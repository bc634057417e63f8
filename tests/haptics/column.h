// A column of layers, and a scripted hand that pushes a needle along it.
#pragma once

#include <utility>
#include <vector>

#include "haptics/haptics.h"

namespace stylet::test {

using Layers = std::vector<std::pair<patient::Tissue, double>>;

// Layers along +x from x = 0, 80 mm wide, surrounded by air. Each thickness is rounded to voxels of
// `pitch_m`.
patient::Package makeColumn(const Layers&, double pitch_m = 0.0001);

// Repeats the column's layers across n x n voxels of `pitch_m`, so that a test can paint labels into them.
patient::Package repeatColumn(const patient::Package& column, int n, double pitch_m);

// Adds simple breathing: at full inhale, everything within 0.3 m of the origin has moved by `travel_m`
// along z.
void addBreathing(patient::Package&, double travel_m);

// Moves the tip and records every event. The needle points along +x unless `axis` is changed.
struct Hand {
    explicit Hand(const patient::Patient& p) : patient(p) {}

    double force() const { return state.force_n; }
    // One step.
    void to(const Vec3& tip_m);
    void to(double x_m) { to({x_m, 0.0003, 0.0002}); }
    // Moves to `x_m` in equal steps of at most `step_m`.
    void sweep(double x_m, double step_m = 0.00009);
    // Returns the events of one kind.
    std::vector<haptics::NeedleEvent> eventsOf(haptics::NeedleEventKind) const;

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
