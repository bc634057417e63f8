#include "app/modeller/image/graph_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stylet::modeller {
namespace {

CutProblem makeProblem(const Index3& dims) {
    const Grid g{dims, Vec3(0.001), Vec3(0.0)};
    CutProblem p;
    p.state = Mask(g, std::uint8_t(CutState::free));
    p.preference = FloatVolume(g);
    p.link = [](std::size_t, std::size_t) { return 1.0f; };
    return p;
}

// A pseudo-random number from -1 to 1, the same on every machine.
float pseudoRandom(std::size_t i) {
    return float(i * 2654435761u % 2001) / 1000.0f - 1.0f;
}

// Total cost of a labelling.
double cutCost(const CutProblem& p, const Mask& object) {
    const Grid& g = p.state.grid;
    double cost = 0.0;
    forEachVoxel(g, [&](const Index3& i) {
        const double preference = double(p.preference[i]);
        cost += object[i] ? std::max(0.0, -preference) : std::max(0.0, preference);
        for (const Index3 step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}})
            if (g.contains(i + step) && object[i] != object[i + step])
                cost += double(p.link(g.offset(i), g.offset(i + step)));
    });
    return cost;
}

void expectGlobalMinimum(CutProblem p) {
    for (std::size_t i = 0; i < p.preference.voxels.size(); ++i)
        p.preference.voxels[i] = 2.0f * pseudoRandom(i + 7);
    p.link = [](std::size_t a, std::size_t b) {
        return 0.3f + 0.3f * pseudoRandom(std::min(a, b) * 31 + std::max(a, b));
    };
    double lowest = std::numeric_limits<double>::max();
    Mask object(p.state.grid);
    const std::size_t voxels = object.voxels.size();
    for (unsigned labelling = 0; labelling < 1u << voxels; ++labelling) {
        for (std::size_t i = 0; i < voxels; ++i)
            object.voxels[i] = labelling >> i & 1u;
        lowest = std::min(lowest, cutCost(p, object));
    }
    EXPECT_NEAR(cutCost(p, minimumCut(p)), lowest, 0.02);
}

TEST(GraphCut, FindsTheGlobalMinimum) {
    expectGlobalMinimum(makeProblem({3, 2, 2}));
}

TEST(GraphCut, CutsTheWeakestLinkBetweenFixedVoxels) {
    CutProblem p = makeProblem({9, 1, 1});
    p.state.voxels[0] = std::uint8_t(CutState::object);
    p.state.voxels[8] = std::uint8_t(CutState::background);
    p.link = [](std::size_t a, std::size_t b) { return std::min(a, b) == 5 ? 0.2f : 1.0f; };
    const Mask object = minimumCut(p);
    for (int x = 0; x < 9; ++x)
        EXPECT_EQ((object[{x, 0, 0}]), x <= 5) << x;
}

TEST(GraphCut, FindsABallInNoise) {
    CutProblem p = makeProblem({24, 24, 24});
    const auto inside = [](const Index3& i) { return glm::length(Vec3(i) - 11.5) < 8.0; };
    const Grid& g = p.state.grid;
    forEachVoxel(g, [&](const Index3& i) {
        p.preference[i] = (inside(i) ? 0.5f : -0.5f) + pseudoRandom(g.offset(i));
    });
    p.link = [](std::size_t, std::size_t) { return 0.4f; };
    const Mask object = minimumCut(p);
    int wrong = 0;
    forEachVoxel(g, [&](const Index3& i) { wrong += inside(i) != (object[i] != 0); });
    EXPECT_LT(wrong, 140);
}

TEST(GraphCut, KeepsFixedVoxelsWithoutFreeOnes) {
    CutProblem p = makeProblem({2, 2, 2});
    for (std::size_t i = 0; i < 8; ++i)
        p.state.voxels[i] = std::uint8_t(i == 3 ? CutState::object : CutState::background);
    const Mask object = minimumCut(p);
    for (std::size_t i = 0; i < 8; ++i)
        EXPECT_EQ(object.voxels[i], i == 3);
}

}  // namespace
}  // namespace stylet::modeller
