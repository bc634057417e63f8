// A binary vessel tree with radii after Murray's law and smooth edges.
// Based on Murray 1926 (r^3 is conserved at a branching).
#include "patient/synth/trees.h"

#include <algorithm>

namespace stylet::patient::synth {

namespace {

double cubeRoot(double v) {
    // Newton's iteration gives the same bits on every machine; libm's cbrt may not.
    double x = v > 1.0 ? v / 3.0 + 0.7 : 1.0;
    for (int i = 0; i < 30; ++i)
        x -= (x * x * x - v) / (3.0 * x * x);
    return x;
}

// Direction of the curve at a node: between the incoming edge and the larger outgoing one.
Vec3 nodeTangent(const Tree& tree, int node) {
    const TreeNode& n = tree.nodes[std::size_t(node)];
    int next = -1;
    for (const int c : n.children)
        if (next < 0 || tree.nodes[std::size_t(c)].leaves > tree.nodes[std::size_t(next)].leaves) next = c;
    const Vec3 in = n.parent >= 0 ? unitOr(n.p - tree.nodes[std::size_t(n.parent)].p, Vec3(0.0)) : Vec3(0.0);
    const Vec3 out = next >= 0 ? unitOr(tree.nodes[std::size_t(next)].p - n.p, Vec3(0.0)) : in;
    return unitOr(in + out, out);
}

struct EdgeCurve {
    Vec3 a, b, ta, tb;
};

EdgeCurve edgeCurve(const Tree& tree, int child) {
    const TreeNode& c = tree.nodes[std::size_t(child)];
    const TreeNode& p = tree.nodes[std::size_t(c.parent)];
    const Vec3 chord = c.p - p.p;
    const double n = length(chord);
    const Vec3 along = unitOr(chord, Vec3(0, 0, 1));
    const Vec3 start = unitOr(nodeTangent(tree, c.parent) * 0.6 + along, along);
    const Vec3 end = unitOr(nodeTangent(tree, child) + along * 0.4, along);
    return {p.p, c.p, start * n * 0.8, end * n * 0.8};
}

}  // namespace

int Tree::add(const Vec3& p, int parent) {
    const int id = int(nodes.size());
    nodes.push_back({p, parent, 0, terminal_radius, {}});
    if (parent >= 0) nodes[std::size_t(parent)].children.push_back(id);
    return id;
}

int Tree::split(int child, const Vec3& p) {
    const int parent = nodes[std::size_t(child)].parent;
    const int id = int(nodes.size());
    nodes.push_back({p, parent, 0, terminal_radius, {child}});
    for (int& c : nodes[std::size_t(parent)].children)
        if (c == child) c = id;
    nodes[std::size_t(child)].parent = id;
    return id;
}

void Tree::updateRadii() {
    // After splits, a parent can come after its children in the list. So count leaves by walking from every
    // leaf to the root.
    for (TreeNode& n : nodes)
        n.leaves = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].children.empty())
            for (int k = int(i); k >= 0; k = nodes[std::size_t(k)].parent)
                ++nodes[std::size_t(k)].leaves;
    for (TreeNode& n : nodes)
        n.radius = terminal_radius * cubeRoot(double(n.leaves));
}

Vec3 edgePoint(const Tree& tree, int child, double t) {
    const EdgeCurve c = edgeCurve(tree, child);
    const double t2 = t * t, t3 = t2 * t;
    return c.a * (2 * t3 - 3 * t2 + 1) + c.ta * (t3 - 2 * t2 + t) + c.b * (3 * t2 - 2 * t3) +
           c.tb * (t3 - t2);
}

Vec3 edgeTangent(const Tree& tree, int child, double t) {
    const EdgeCurve c = edgeCurve(tree, child);
    const double t2 = t * t;
    return unitOr(c.a * (6 * t2 - 6 * t) + c.ta * (3 * t2 - 4 * t + 1) + c.b * (6 * t - 6 * t2) +
                      c.tb * (3 * t2 - 2 * t),
                  Vec3(0, 0, 1));
}

std::vector<Stroke> treeStrokes(const Tree& tree, double taper) {
    std::vector<Stroke> strokes;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        const TreeNode& n = tree.nodes[i];
        if (n.parent < 0) continue;
        const double span = length(n.p - tree.nodes[std::size_t(n.parent)].p);
        const int parts = std::max(2, int(span / 3.0));
        const double r1 = n.children.empty() ? n.radius * taper : n.radius;
        Vec3 last = edgePoint(tree, int(i), 0.0);
        for (int k = 1; k <= parts; ++k) {
            const double t0 = double(k - 1) / parts, t1 = double(k) / parts;
            const Vec3 p = edgePoint(tree, int(i), t1);
            strokes.push_back({last, p, n.radius + (r1 - n.radius) * t0, n.radius + (r1 - n.radius) * t1});
            last = p;
        }
    }
    return strokes;
}

}  // namespace stylet::patient::synth
