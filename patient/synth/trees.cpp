// The trees of the liver: an anatomical scaffold (Couinaud's segments) filled in by growth, and ducts
// beside the portal branches.
#include "patient/synth/trees.h"

#include <cmath>

#include "patient/synth/growth.h"

namespace stylet::patient::synth {

namespace {

constexpr double kPortalTerminal_mm = 1.45;

using Depth = std::function<double(const Vec3&)>;

// Moves a point of the scaffold into the liver.
Vec3 moveInside(const Depth& depth, Vec3 p, double wanted_mm) {
    for (int i = 0; i < 30 && depth(p) < wanted_mm; ++i) {
        const double h = 2.0;
        const Vec3 gradient{depth({p.x + h, p.y, p.z}) - depth({p.x - h, p.y, p.z}),
                            depth({p.x, p.y + h, p.z}) - depth({p.x, p.y - h, p.z}),
                            depth({p.x, p.y, p.z + h}) - depth({p.x, p.y, p.z - h})};
        p += unitOr(gradient, Vec3(0, 0, 1)) * 2.0;
    }
    return p;
}

// Smallest distance between the walls of a straight edge and those of the obstacles.
double clearance(const std::vector<Stroke>& obstacles, const Vec3& from, const Vec3& to, double radius) {
    double least = 1e9;
    for (int k = 2; k <= 10; ++k)
        for (const Stroke& o : obstacles)
            least =
                std::min(least, roundCone(mixed(from, to, k / 10.0), o.a, o.b, o.ra, o.rb).distance - radius);
    return least;
}

struct Scaffold {
    Tree& tree;
    const Depth& depth;
    Random& random;
    const std::vector<Stroke>& obstacles;

    // Adds a node near `p` inside the liver whose edge to the parent is clear of obstacles. Uses the first
    // suitable position of several, otherwise the best one.
    int add(const Vec3& p, int parent) {
        Vec3 best(0.0);
        double most = -1e9;
        for (int i = 0; i < 30 && most < kRoom_mm; ++i) {
            const Vec3 place = moveInside(depth, p + random.jitter3(5.0 + 0.25 * i), 9.0);
            const double room = clearance(obstacles, tree.nodes[std::size_t(parent)].p, place, 2.5);
            if (room > most) most = room, best = place;
        }
        return tree.add(best, parent);
    }

    static constexpr double kRoom_mm = 4.0;
};

Tree portalScaffold(const Anatomy& a, const Depth& depth, Random& random) {
    const std::vector<Stroke> free;
    Tree tree;
    tree.terminal_radius = kPortalTerminal_mm;
    const Vec3 h = a.organs.hilum;
    Scaffold s{tree, depth, random, free};
    const int root = tree.add(h + Vec3(-6.0, -2.0, -14.0), -1);
    const int hilum = tree.add(h, root);
    const int right = s.add(h + Vec3(20.0, 0.0, 7.0), hilum);
    const int anterior = s.add(h + Vec3(36.0, 14.0, 20.0), right);
    s.add(h + Vec3(44.0, 22.0, 48.0), anterior);  // segment 8
    s.add(h + Vec3(54.0, 34.0, -4.0), anterior);  // segment 5
    const int posterior = s.add(h + Vec3(42.0, -20.0, 4.0), right);
    s.add(h + Vec3(58.0, -34.0, 34.0), posterior);   // segment 7
    s.add(h + Vec3(68.0, -14.0, -30.0), posterior);  // segment 6
    const int left = s.add(h + Vec3(-20.0, 10.0, 14.0), hilum);
    const int umbilical = s.add(h + Vec3(-38.0, 22.0, 24.0), left);
    s.add(h + Vec3(-62.0, 26.0, 42.0), umbilical);  // segments 2 and 3
    s.add(h + Vec3(-26.0, 46.0, 32.0), umbilical);  // segment 4
    tree.updateRadii();
    return tree;
}

Tree hepaticScaffold(const Anatomy& a, const Depth& depth, Random& random,
                     const std::vector<Stroke>& portal) {
    Tree tree;
    tree.terminal_radius = 1.2;
    const double z = 112.0 + (a.dome_right_mm - 132.0);
    const Vec3 cava = a.cava(z);
    Scaffold s{tree, depth, random, portal};
    const int root = tree.add(cava, -1);
    const int right = s.add(cava + Vec3(28.0, 2.0, -8.0), root);
    const int right2 = s.add(cava + Vec3(54.0, -6.0, -34.0), right);
    s.add(cava + Vec3(68.0, -2.0, -74.0), right2);
    const int common = s.add(cava + Vec3(1.0, 16.0, -3.0), root);
    const int middle = s.add(cava + Vec3(12.0, 34.0, -16.0), common);
    const int middle2 = s.add(cava + Vec3(22.0, 50.0, -42.0), middle);
    s.add(cava + Vec3(36.0, 56.0, -72.0), middle2);
    const int left = s.add(cava + Vec3(-22.0, 32.0, -10.0), common);
    s.add(cava + Vec3(-52.0, 46.0, -18.0), left);
    tree.updateRadii();
    return tree;
}

// Ducts are dilated: as wide as the portal branch in the periphery, half as wide at the hilum.
double ductRadius(const TreeNode& portal) {
    return 1.55 + 0.45 * (portal.radius - kPortalTerminal_mm);
}

// A duct runs beside every portal branch, shifted along the normal of the plane in which the branch divides.
// So the duct's division is a copy of the portal one, and ducts and branches do not cross.
class Ducts {
  public:
    explicit Ducts(const Tree& portal) : portal_(portal), side_(portal.nodes.size()) {}

    std::vector<Stroke> strokes() {
        side_[0] = Vec3(0.45, 0.85, -0.2);
        follow(0);
        return std::move(strokes_);
    }
    Vec3 root() const { return root_; }

  private:
    double offset(const TreeNode& n) const { return n.radius + ductRadius(n) + 0.5; }

    void follow(int node) {
        const TreeNode& n = portal_.nodes[std::size_t(node)];
        if (n.children.size() == 2) {
            const Vec3 plane =
                cross(edgeTangent(portal_, n.children[0], 0.3), edgeTangent(portal_, n.children[1], 0.3));
            if (length(plane) > 0.25 && node != 0) {
                const double sign = dot(plane, side_[std::size_t(node)]) < 0.0 ? -1.0 : 1.0;
                side_[std::size_t(node)] = unitOr(plane * sign, side_[std::size_t(node)]);
            }
        }
        for (const int c : n.children) {
            side_[std::size_t(c)] = side_[std::size_t(node)];
            side_[std::size_t(c)] = transportedNormal(c);
            follow(c);
        }
        if (node != 0) edge(node);
    }

    Vec3 transportedNormal(int child) const {
        const Vec3 t = edgeTangent(portal_, child, 1.0);
        const Vec3& s = side_[std::size_t(child)];
        return unitOr(s - t * dot(t, s), s);
    }

    void edge(int child) {
        const TreeNode& n = portal_.nodes[std::size_t(child)];
        const TreeNode& p = portal_.nodes[std::size_t(n.parent)];
        const double r0 = ductRadius(n);
        const double r1 = n.children.empty() ? r0 * 0.8 : r0;
        // The duct starts at its parent's duct and moves to its place beside its own portal branch.
        const double begin = offset(p), end = offset(n);
        const int parts = std::max(3, int(length(n.p - p.p) / 2.5));
        Vec3 last(0.0);
        for (int k = 0; k <= parts; ++k) {
            const double t = double(k) / parts;
            const Vec3 tangent = edgeTangent(portal_, child, t);
            Vec3 s = mixed(side_[std::size_t(n.parent)], side_[std::size_t(child)], t);
            if (k > 0) s -= tangent * (dot(tangent, s) * std::min(1.0, 2.0 * t));
            const double blend = ramp(t, 0.0, 0.6);
            const Vec3 q = edgePoint(portal_, child, t) +
                           unitOr(s, side_[std::size_t(child)]) * (begin + (end - begin) * blend);
            if (k == 0 && n.parent == 0) root_ = q;
            if (k > 0) {
                const double t0 = double(k - 1) / parts;
                strokes_.push_back({last, q, r0 + (r1 - r0) * t0, r0 + (r1 - r0) * t});
            }
            last = q;
        }
    }

    const Tree& portal_;
    std::vector<Vec3> side_;
    std::vector<Stroke> strokes_;
    Vec3 root_{0.0};
};

void append(std::vector<Stroke>& to, const std::vector<Stroke>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

std::vector<Stroke> extrahepaticPortal(const Anatomy& a, const Vec3& root, double radius) {
    const Vec3 confluence{10.0, 3.0, -8.0};
    const Vec3& spleen = a.organs.spleen.centre;
    std::vector<Stroke> all =
        tube({{confluence, 6.2}, {mixed(confluence, root, 0.5) + Vec3(1, -2, 0), 6.2}, {root, radius}}, 2.5);
    append(all, tube({{confluence, 5.4},
                      {{13.0, 8.0, -35.0}, 5.2},
                      {{14.0, 14.0, -75.0}, 4.6},
                      {{10.0, 16.0, -125.0}, 4.0}},
                     3.0));
    append(all, tube({{confluence, 4.6},
                      {{-18.0, 3.0, 8.0}, 4.3},
                      {{-46.0, -13.0, 19.0}, 4.0},
                      {spleen + Vec3(16.0, -2.0, -12.0), 3.4}},
                     3.0));
    return all;
}

}  // namespace

HepaticTrees growHepaticTrees(const Anatomy& a) {
    Random random(a.seed, 2);
    const Depth depth = [&a](const Vec3& p) {
        const Vec3 cava = a.cava(p.z);
        const double vein =
            std::sqrt((p.x - cava.x) * (p.x - cava.x) + (p.y - cava.y) * (p.y - cava.y)) - 13.0;
        return std::min(-a.liverDistance(p), p.z > 20.0 ? vein : 1e3);
    };
    HepaticTrees trees;
    // The large branches of both trees come first, so that each has room. Then the portal tree grows and
    // leaves room for the ducts. Then the hepatic veins grow in the remaining space.
    Tree portal = portalScaffold(a, depth, random);
    Tree veins = hepaticScaffold(a, depth, random, treeStrokes(portal, 1.0));
    std::vector<Stroke> great_veins = treeStrokes(veins, 1.0);
    for (Stroke& v : great_veins)
        v.ra += 1.0, v.rb += 1.0;
    const GrowthSettings between_veins{.terminals = 78,
                                       .depth_mm = 8.0,
                                       .own_gap_mm = 4.5,
                                       .other_gap_mm = 5.5,
                                       .gap_per_radius = 1.6,
                                       .box = kLiverBox};
    growTree(portal, random, between_veins, depth, great_veins);
    trees.portal = treeStrokes(portal, 0.75);

    Ducts ducts(portal);
    trees.ducts = ducts.strokes();

    const Vec3 portal_root = portal.nodes[0].p;
    const double trunk = portal.nodes[0].radius;
    trees.extrahepatic_portal = extrahepaticPortal(a, portal_root, trunk);
    const OrganPlan& o = a.organs;
    const double common = 5.0;
    const Vec3 hepatic_duct = ducts.root();
    const Vec3 knee = mixed(hepatic_duct, o.tumour, 0.5) + Vec3(5.0, 2.0, 0.0);
    trees.extrahepatic_duct = tube({{hepatic_duct, common},
                                    {knee, common},
                                    {o.tumour + Vec3(1.0, 1.0, o.tumour_radius * 0.6), common * 0.7}},
                                   2.0);
    const Vec3 neck = o.gallbladder.centre - o.gallbladder.axes[0] * (o.gallbladder.radii.x - 2.0);
    append(trees.extrahepatic_duct,
           tube({{knee, 2.2}, {mixed(knee, neck, 0.5) + Vec3(0, 0, 4.0), 2.0}, {neck, 2.4}}, 2.0));

    std::vector<Stroke> occupied = trees.portal;
    append(occupied, trees.ducts);
    append(occupied, trees.extrahepatic_portal);
    const GrowthSettings in_gaps{
        .terminals = 60, .other_gap_mm = 1.4, .gap_per_radius = 0.5, .box = kLiverBox};
    growTree(veins, random, in_gaps, depth, occupied);
    trees.hepatic_veins = treeStrokes(veins, 0.7);
    return trees;
}

}  // namespace stylet::patient::synth
