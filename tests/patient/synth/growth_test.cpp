#include "patient/synth/growth.h"

#include <gtest/gtest.h>

namespace stylet::patient::synth {
namespace {

double depthInBall(const Vec3& p) {
    return 60.0 - length(p);
}

Tree grownInBall(std::uint64_t seed) {
    Tree tree;
    tree.terminal_radius = 1.0;
    const int root = tree.add({0, 0, -58}, -1);
    tree.add({0, 0, -20}, root);
    GrowthSettings settings;
    settings.terminals = 40;
    settings.box = {Vec3(-60.0), Vec3(60.0)};
    Random random(seed, 9);
    growTree(tree, random, settings, depthInBall, {});
    return tree;
}

TEST(Growth, ReachesItsTerminalsInsideTheOrgan) {
    const Tree tree = grownInBall(3);
    EXPECT_EQ(tree.nodes[0].leaves, 40);
    for (const TreeNode& n : tree.nodes) {
        if (n.parent < 0) continue;
        EXPECT_GT(depthInBall(n.p), 1.0);
        EXPECT_LE(n.children.size(), 2u);
    }
}

TEST(Growth, RadiiFollowMurraysLaw) {
    for (const TreeNode& n : grownInBall(4).nodes) {
        if (n.children.empty()) {
            EXPECT_DOUBLE_EQ(n.radius, 1.0);
            continue;
        }
        EXPECT_NEAR(n.radius * n.radius * n.radius, n.leaves, 1e-9);
    }
}

TEST(Growth, IsRepeatable) {
    const Tree a = grownInBall(5), b = grownInBall(5), c = grownInBall(6);
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    for (std::size_t i = 0; i < a.nodes.size(); ++i)
        EXPECT_EQ(a.nodes[i].p, b.nodes[i].p);
    EXPECT_NE(a.nodes.back().p, c.nodes.back().p);
}

TEST(Growth, EdgesJoinSmoothly) {
    const Tree tree = grownInBall(7);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        const TreeNode& n = tree.nodes[i];
        if (n.parent < 0) continue;
        EXPECT_LT(length(edgePoint(tree, int(i), 0.0) - tree.nodes[std::size_t(n.parent)].p), 1e-9);
        EXPECT_LT(length(edgePoint(tree, int(i), 1.0) - n.p), 1e-9);
    }
}

}  // namespace
}  // namespace stylet::patient::synth
