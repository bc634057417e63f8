// Constrained constructive growth. Terminals are drawn far from the tree and connected where the new
// branch is short and turns little, inside the organ and clear of existing structures. Based on Schreiner
// and Buxbaum 1993 (constrained constructive optimisation), with a fixed anatomical scaffold.
#pragma once

#include <functional>

#include "patient/synth/random.h"
#include "patient/synth/trees.h"

namespace stylet::patient::synth {

struct GrowthSettings {
    int terminals = 50;           // number of terminals to reach
    double depth_mm = 6.0;        // minimum depth of the branches inside the organ
    double own_gap_mm = 4.0;      // gap between walls of unrelated branches of this tree
    double other_gap_mm = 1.5;    // gap to the walls of `obstacles`
    double gap_per_radius = 0.0;  // share of the other branch's radius added to own_gap_mm
    double min_edge_mm = 7.0;
    Box box;
};

// Grows `tree`. depth(p) is the depth of p inside the organ, positive inside.
void growTree(Tree&, Random&, const GrowthSettings&, const std::function<double(const Vec3&)>& depth,
              const std::vector<Stroke>& obstacles);

}  // namespace stylet::patient::synth
