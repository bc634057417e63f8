#include "patient/synth/growth.h"

#include <algorithm>
#include <tuple>

namespace stylet::patient::synth {

namespace {

// A possible way to connect a terminal: at `p` on the edge that ends in `child`, or as a child of `node`.
struct Join {
    int child = -1, node = -1;
    Vec3 p{0.0};
    double cost = 0.0;
};

class Grower {
  public:
    Grower(Tree& tree, Random& random, const GrowthSettings& settings,
           const std::function<double(const Vec3&)>& depth, const std::vector<Stroke>& obstacles)
        : tree_(tree), random_(random), s_(settings), depth_(depth), obstacles_(obstacles) {}

    void run() {
        tree_.updateRadii();
        int missed = 0;
        while (leaves() < s_.terminals && missed < 150)
            missed = addTerminal() ? 0 : missed + 1;
    }

  private:
    int leaves() const { return tree_.nodes[0].leaves; }

    double distanceToTree(const Vec3& p) const {
        double best = 1e9;
        for (const TreeNode& n : tree_.nodes)
            if (n.parent >= 0)
                best = std::min(best, roundCone(p, tree_.nodes[std::size_t(n.parent)].p, n.p, 0, 0).distance);
        return best;
    }

    // Draws the candidate farthest from the tree, so that the branches fill space evenly.
    bool drawTerminal(Vec3& terminal) {
        double best = s_.own_gap_mm + 4.0;
        bool found = false;
        for (int i = 0; i < 14; ++i) {
            const Vec3 p = random_.uniform3(s_.box.low, s_.box.high);
            if (depth_(p) < s_.depth_mm) continue;
            const double d = distanceToTree(p);
            if (d > best) best = d, terminal = p, found = true;
        }
        return found;
    }

    std::vector<Join> joins(const Vec3& terminal) const {
        std::vector<Join> list;
        for (std::size_t i = 0; i < tree_.nodes.size(); ++i) {
            const TreeNode& n = tree_.nodes[i];
            if (n.parent < 0) continue;
            const Vec3& a = tree_.nodes[std::size_t(n.parent)].p;
            const double edge = length(n.p - a);
            if (n.children.size() < 2) {
                // A branch that extends an end of the tree must not turn back.
                const Vec3 out = unitOr(terminal - n.p, Vec3(0.0)), in = unitOr(n.p - a, Vec3(0.0));
                const double turn = dot(out, in);
                const double far = length(terminal - n.p);
                if (turn > 0.35 && far > s_.min_edge_mm)
                    list.push_back(
                        {-1, int(i), n.p, far * (1.3 - 0.3 * turn) + (n.children.empty() ? 6.0 : 0.0)});
            }
            if (edge < 2.0 * s_.min_edge_mm) continue;
            const ConeHit hit = roundCone(terminal, a, n.p, 0.0, 0.0);
            // Branch off upstream of the nearest point, which gives an acute angle.
            const double margin = s_.min_edge_mm / edge;
            const double share = std::clamp(hit.share - 0.45 * hit.distance / edge, margin, 1.0 - margin);
            const Vec3 on = mixed(a, n.p, share);
            const Vec3 p = mixed(on, terminal, std::min(0.12, 4.0 / (length(terminal - on) + 1e-9)));
            const double turn = dot(unitOr(terminal - p, Vec3(0.0)), unitOr(n.p - a, Vec3(0.0)));
            if (turn < -0.2) continue;
            list.push_back({int(i), -1, p, length(terminal - p) * (1.25 - 0.25 * turn)});
        }
        const auto order = [](const Join& j) { return std::tuple(j.cost, j.child, j.node); };
        std::sort(list.begin(), list.end(),
                  [&](const Join& l, const Join& r) { return order(l) < order(r); });
        if (list.size() > 8) list.resize(8);
        return list;
    }

    bool clear(const Vec3& from, const Vec3& to) const {
        const double span = length(to - from);
        const int samples = std::max(3, int(span / 2.5));
        for (int i = 1; i <= samples; ++i) {
            const Vec3 p = mixed(from, to, double(i) / samples);
            const double gone = length(p - from);
            if (depth_(p) < std::min(s_.depth_mm, 2.0 + gone * 0.5)) return false;
            for (const Stroke& o : obstacles_) {
                const double r = std::max(o.ra, o.rb) + tree_.terminal_radius + s_.other_gap_mm;
                if (roundCone(p, o.a, o.b, 0.0, 0.0).distance < r && gone > 3.0) return false;
            }
            for (const TreeNode& n : tree_.nodes) {
                if (n.parent < 0) continue;
                const Vec3& a = tree_.nodes[std::size_t(n.parent)].p;
                const double need =
                    n.radius * (1.0 + s_.gap_per_radius) + tree_.terminal_radius + s_.own_gap_mm;
                const ConeHit hit = roundCone(p, a, n.p, 0.0, 0.0);
                // Close to its origin a new branch may be near the tree; farther away it needs the full gap.
                if (hit.distance < std::min(need, gone * 0.55)) return false;
            }
        }
        return true;
    }

    bool addTerminal() {
        Vec3 terminal;
        if (!drawTerminal(terminal)) return false;
        for (const Join& j : joins(terminal)) {
            if (!clear(j.p, terminal)) continue;
            const int at = j.node >= 0 ? j.node : tree_.split(j.child, j.p);
            tree_.add(terminal, at);
            tree_.updateRadii();
            return true;
        }
        return false;
    }

    Tree& tree_;
    Random& random_;
    const GrowthSettings& s_;
    const std::function<double(const Vec3&)>& depth_;
    const std::vector<Stroke>& obstacles_;
};

}  // namespace

void growTree(Tree& tree, Random& random, const GrowthSettings& settings,
              const std::function<double(const Vec3&)>& depth, const std::vector<Stroke>& obstacles) {
    Grower(tree, random, settings, depth, obstacles).run();
}

}  // namespace stylet::patient::synth
