#include "app/modeller/segmentation/graph_cut.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stylet::modeller {
namespace {

CutProblem problemOf(const Index3& dims) {
    const Grid g{dims, Vec3(0.001), Vec3(0.0)};
    CutProblem p;
    p.state = Mask(g, std::uint8_t(CutState::free));
    p.preference = FloatVolume(g);
    p.link = [](std::size_t, std::size_t) { return 1.0f; };
    return p;
}

// A pseudo-random number from -1 to 1, the same on every machine.
float someNumber(std::size_t i) {
    return float(i * 2654435761u % 2001) / 1000.0f - 1.0f;
}

// Total cost of a labelling.
double costOf(const CutProblem& p, const Mask& object) {
    const Grid& g = p.state.grid;
    double cost = 0.0;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                const double preference = double(p.preference[i]);
                cost += object[i] ? std::max(0.0, -preference) : std::max(0.0, preference);
                for (const Index3 step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}})
                    if (g.contains(i + step) && object[i] != object[i + step])
                        cost += double(p.link(g.offset(i), g.offset(i + step)));
            }
    return cost;
}

void expectTheCheapestOfAll(CutProblem p) {
    for (std::size_t i = 0; i < p.preference.voxels.size(); ++i)
        p.preference.voxels[i] = 2.0f * someNumber(i + 7);
    p.link = [](std::size_t a, std::size_t b) {
        return 0.3f + 0.3f * someNumber(std::min(a, b) * 31 + std::max(a, b));
    };
    double least = std::numeric_limits<double>::max();
    Mask object(p.state.grid);
    const std::size_t voxels = object.voxels.size();
    for (unsigned labelling = 0; labelling < 1u << voxels; ++labelling) {
        for (std::size_t i = 0; i < voxels; ++i)
            object.voxels[i] = labelling >> i & 1u;
        least = std::min(least, costOf(p, object));
    }
    EXPECT_NEAR(costOf(p, minimumCut(p)), least, 0.02);
}

TEST(GraphCut, IsTheCheapestOfAllLabellings) {
    expectTheCheapestOfAll(problemOf({3, 2, 2}));
}

TEST(GraphCut, RunsThroughTheWeakestLinkBetweenWhatIsFixed) {
    CutProblem p = problemOf({9, 1, 1});
    p.state.voxels[0] = std::uint8_t(CutState::object);
    p.state.voxels[8] = std::uint8_t(CutState::background);
    p.link = [](std::size_t a, std::size_t b) { return std::min(a, b) == 5 ? 0.2f : 1.0f; };
    const Mask object = minimumCut(p);
    for (int x = 0; x < 9; ++x)
        EXPECT_EQ((object[{x, 0, 0}]), x <= 5) << x;
}

TEST(GraphCut, FindsABallInNoise) {
    CutProblem p = problemOf({24, 24, 24});
    const auto inside = [](const Index3& i) { return glm::length(Vec3(i) - 11.5) < 8.0; };
    for (int z = 0; z < 24; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x) {
                const Index3 i{x, y, z};
                p.preference[i] = (inside(i) ? 0.5f : -0.5f) + someNumber(p.state.grid.offset(i));
            }
    p.link = [](std::size_t, std::size_t) { return 0.4f; };
    const Mask object = minimumCut(p);
    int wrong = 0;
    for (int z = 0; z < 24; ++z)
        for (int y = 0; y < 24; ++y)
            for (int x = 0; x < 24; ++x)
                wrong += inside({x, y, z}) != (object[{x, y, z}] != 0);
    EXPECT_LT(wrong, 140);
}

TEST(GraphCut, OfNothingFreeIsWhatWasFixed) {
    CutProblem p = problemOf({2, 2, 2});
    for (std::size_t i = 0; i < 8; ++i)
        p.state.voxels[i] = std::uint8_t(i == 3 ? CutState::object : CutState::background);
    const Mask object = minimumCut(p);
    for (std::size_t i = 0; i < 8; ++i)
        EXPECT_EQ(object.voxels[i], i == 3);
}

}  // namespace
}  // namespace stylet::modeller
