// The three trees of the liver: portal vein, hepatic veins, dilated bile ducts.
#pragma once

#include <vector>

#include "patient/synth/anatomy.h"
#include "patient/synth/canvas.h"

namespace stylet::patient::synth {

struct TreeNode {
    Vec3 p{0.0};
    int parent = -1;
    int leaves = 0;       // terminals downstream
    double radius = 0.0;  // of the edge from the parent
    std::vector<int> children;
};

// Built by adding terminals one by one. Radii follow Murray's law: r^3 is the sum of the children's r^3.
struct Tree {
    std::vector<TreeNode> nodes;
    double terminal_radius = 1.0;

    int add(const Vec3& p, int parent);
    // Inserts a node into the edge that ends in `child`.
    int split(int child, const Vec3& p);
    void updateRadii();
};

// Position and direction along an edge. The edge is a curve with continuous tangents at the nodes; share is
// in [0, 1].
Vec3 edgePoint(const Tree&, int child, double share);
Vec3 edgeTangent(const Tree&, int child, double share);
std::vector<Stroke> treeStrokes(const Tree&, double taper);

struct HepaticTrees {
    std::vector<Stroke> portal, hepatic_veins, ducts;
    std::vector<Stroke> extrahepatic_portal,
        extrahepatic_duct;  // trunk, confluence; common duct down to the tumour
};
HepaticTrees growHepaticTrees(const Anatomy&);

}  // namespace stylet::patient::synth
