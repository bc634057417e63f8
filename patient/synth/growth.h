// Constrained constructive growth: terminals are drawn far from the tree and joined to it where the added
// volume is least, inside the organ and clear of what is already there. Based on Schreiner and Buxbaum 1993
// (constrained constructive optimisation), with a fixed anatomical scaffold.
#pragma once

#include <functional>

#include "patient/synth/random.h"
#include "patient/synth/trees.h"

namespace stylet::patient::synth {

struct GrowthSettings {
    int terminals = 50;           // to reach
    double depth_mm = 6.0;        // how far inside the organ the branches stay
    double own_gap_mm = 4.0;      // between walls of branches of this tree that are not neighbours
    double other_gap_mm = 1.5;    // to the walls of `obstacles`
    double gap_per_radius = 0.0;  // added to own_gap, times the other branch's radius (room for a companion)
    double min_edge_mm = 7.0;
    Box box;
};

// depth(p): how deep inside the organ p lies, positive inside.
void growTree(Tree&, Random&, const GrowthSettings&, const std::function<double(const Vec3&)>& depth,
              const std::vector<Stroke>& obstacles);

}  // namespace stylet::patient::synth
