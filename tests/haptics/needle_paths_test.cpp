// Random paths through random columns with random force tables. The result must match the naive needle, and
// must not depend on how the path is divided into ticks.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/naive_needle.h"
#include "tests/haptics/random_column.h"

namespace stylet::haptics {
namespace {

using test::below;
using test::Hand;
using test::Random;
using test::uniform;

constexpr double kShares[] = {0.0, 0.25, 0.5, 0.8, 1.0};

// Returns the turning points of a random path that ends deep. The points avoid the layer borders, where
// rounding could put the tip on different sides in the two solvers.
std::vector<double> turningPoints(Random& random, double length_m) {
    std::vector<double> points;
    double x_m = 0.004;
    for (int i = 0; i < 12; ++i) {
        x_m += i % 2 == 0 ? uniform(random, 0.0005, 0.007) : -uniform(random, 0.0001, 0.005);
        x_m = std::clamp(x_m, 0.003, length_m - 0.002);
        points.push_back((std::floor(x_m * 1e5) + 0.5) * 1e-5 + 0.0000005);
    }
    return points;
}

struct Case {
    explicit Case(std::uint64_t seed) : random(seed), layers(test::randomLayers(random)) {
        // Starts inside tissue, because this test excludes the surface.
        layers.insert(layers.begin(), {Tissue::soft, 0.003});
        package = test::makeColumn(layers);
        package.tissues = test::randomTable(random);
        settings.a1_share = kShares[seed % std::size(kShares)];
        settings.cut_reach_m = 0.00153;  // not a multiple of the layer thickness
        points = turningPoints(random, package.ct.grid.dims.x * 0.0001);
    }
    Random random;
    test::Layers layers;
    patient::Package package;
    NeedleSettings settings;
    std::vector<double> points;
};

// Distance of the tip from its last event. NaiveNeedle::distanceToEvent() is not enough: `hand` may puncture
// a border up to a micrometre before the naive needle.
double distanceToLastEvent(const Hand& hand) {
    if (hand.events.empty()) return HUGE_VAL;
    const NeedleEvent& last = hand.events.back();
    return std::fabs(hand.state.depth_m - last.border.depth_m - last.tenting_m);
}

// HZ-TEACH-02
TEST(NeedlePaths, InsertionAndWithdrawalEqualTheNaiveNeedle) {
    std::size_t compared = 0, held = 0, negative = 0, abandoned = 0;
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE(seed);
        Case c(seed);
        const patient::Patient patient(c.package);
        Hand hand(patient);
        hand.settings = c.settings;
        test::NaiveNeedle naive(c.layers, c.package.tissues, c.settings);
        hand.to(0.5 * test::NaiveNeedle::kStep_m);
        for (const double x_m : c.points) {
            const double from_m = hand.state.tip_deformed_m.x;
            for (int i = 1; i <= 40; ++i) {
                const double at_m = from_m + (x_m - from_m) * i / 40;
                naive.to(at_m), hand.to(at_m);
                if (naive.distanceToEvent() < 5e-6 || distanceToLastEvent(hand) < 5e-6) continue;
                // Tolerance: the steepest slope times a micrometre for each border and puncture so far.
                ASSERT_NEAR(hand.force(), naive.force(), 2.0 * 3000.0 * 6e-6) << "at " << at_m;
                ++compared;
                held += hand.state.phase == Phase::tenting;
                negative += hand.force() < 0.0;
            }
            // The path turned within a micrometre of a puncture: only one of the solvers has punctured.
            if ((hand.state.phase == Phase::tenting) != naive.isTenting()) {
                ++abandoned;
                break;
            }
        }
    }
    EXPECT_GT(compared, 150000u);
    EXPECT_GT(held, 20000u);
    EXPECT_GT(negative, 20000u);
    EXPECT_LE(abandoned, 20u);
}

// The model says: "Cuts and borders are solved inside the step". Compares one tick per leg with many ticks
// per leg.
TEST(NeedlePaths, ForceDoesNotDependOnTheTickDivision) {
    std::size_t compared = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        SCOPED_TRACE(seed);
        Case c(seed);
        const patient::Patient patient(c.package);
        Hand leaps(patient), steps(patient), creeps(patient);
        for (Hand* hand : {&leaps, &steps, &creeps}) {
            hand->settings = c.settings;
            hand->to(0.0);
        }
        for (const double x_m : c.points) {
            leaps.to(x_m);
            while (steps.state.tip_deformed_m.x != x_m) {
                const double left_m = x_m - steps.state.tip_deformed_m.x;
                const double step_m = uniform(c.random, 0.0, 0.001);
                steps.to(std::fabs(left_m) <= step_m ? x_m : x_m - left_m + std::copysign(step_m, left_m));
            }
            creeps.sweep(x_m, 0.00003);
            for (const Hand* other : {&steps, &creeps}) {
                ASSERT_NEAR(leaps.force(), other->force(), 1e-8) << "at " << x_m;
                ASSERT_EQ(leaps.state.phase, other->state.phase);
                ASSERT_EQ(leaps.state.tissue, other->state.tissue);
                ASSERT_EQ(leaps.state.queued_count, other->state.queued_count);
                ASSERT_EQ(leaps.state.cut_count, other->state.cut_count);
                ASSERT_EQ(leaps.events.size(), other->events.size());
                for (std::size_t i = 0; i < leaps.events.size(); ++i) {
                    ASSERT_EQ(leaps.events[i].kind, other->events[i].kind);
                    ASSERT_NEAR(leaps.events[i].tenting_m, other->events[i].tenting_m, 1e-9);
                    ASSERT_NEAR(leaps.events[i].force_after_n, other->events[i].force_after_n, 1e-8);
                }
                ++compared;
            }
        }
    }
    EXPECT_GT(compared, 15000u);
}

}  // namespace
}  // namespace stylet::haptics
