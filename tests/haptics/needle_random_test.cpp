// Compares the sampled solver with the exact one, for random force tables and layers.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/random_column.h"

namespace stylet::haptics {
namespace {

using test::below;
using test::Hand;
using test::Random;
using test::randomLayers;
using test::randomTable;
using test::uniform;

double distanceToEvent(const ExactForce& exact, double depth_m) {
    double nearest = HUGE_VAL;
    for (const ExactEvent& e : exact.events)
        nearest = std::min(nearest, std::fabs(e.depth_m - depth_m));
    return nearest;
}

struct Coverage {
    std::size_t compared = 0, punctures = 0, pushed = 0, withdrawn = 0;
};

// Checks one puncture against Eq. 1 and the threshold from the table. `held` is the event at which its border
// began to tent.
void expectClosedForm(const patient::TissueTable& table, double friction_scale, const NeedleEvent& held,
                      const NeedleEvent& cut) {
    ASSERT_EQ(held.kind, NeedleEventKind::border);
    ASSERT_EQ(held.border.to, cut.border.to);
    ASSERT_EQ(held.border.reference_m, cut.border.reference_m);
    const patient::TissueRow& row = table[std::size_t(cut.border.to)];
    const double behind_m = (row.cut_force_n - held.force_before_n) / row.stiffness_n_per_m;
    // A border reached during the tenting of another one starts tenting at the tip, already behind its rest
    // position.
    ASSERT_NEAR(cut.tenting_m - held.tenting_m, behind_m, 1e-9);
    ASSERT_NEAR(cut.force_before_n, row.cut_force_n, 1e-9);
    ASSERT_NEAR(cut.force_after_n, std::min(row.cut_force_n, friction_scale * row.friction_n), 1e-9);
}

// Moves one needle along a straight path in steps of random length and compares every sample with the exact
// solver.
void compare(const patient::Patient& patient, const Vec3& entry, const Vec3& end, Random& random,
             Coverage& coverage) {
    const Vec3 way = end - entry;
    const double length_m = std::sqrt(glm::dot(way, way));
    Hand hand(patient);
    hand.axis = way / length_m;
    hand.settings.a1_share = uniform(random, 0.0, 1.0);
    // A needle of 17 G or 22 G; the cut reach is not a multiple of the layer thickness.
    const bool thin = below(random, 2) == 0;
    hand.settings.cut_reach_m = thin ? 0.00073 : 0.00153;
    hand.settings.friction_scale = thin ? 0.48 : 1.0;
    const patient::TissueMap map(patient);
    ExactSolver solver(map, hand.settings);
    const ExactForce& exact = solver.solve(entry, end);

    hand.to(entry);
    double depth_m = 0.0, worst_n = 0.0;
    while (depth_m < length_m) {
        depth_m = std::min(length_m, depth_m + uniform(random, 0.0, 0.0003));
        hand.to(entry + hand.axis * depth_m);
        if (distanceToEvent(exact, depth_m) < 1e-9) continue;
        worst_n = std::max(worst_n, std::fabs(hand.force() - exact.at(depth_m)));
        ++coverage.compared;
    }
    ASSERT_LT(worst_n, 1e-9);

    ASSERT_EQ(hand.events.size(), exact.events.size());
    NeedleEvent held;
    for (std::size_t i = 0; i < exact.events.size(); ++i) {
        const NeedleEvent& a = hand.events[i];
        const ExactEvent& b = exact.events[i];
        const double border_m = glm::dot(a.border.reference_m - entry, hand.axis);
        ASSERT_EQ(a.kind, b.kind) << "event " << i;
        ASSERT_EQ(a.border.to, b.tissue);
        ASSERT_EQ(a.border.to_label, b.label);
        ASSERT_NEAR(border_m, b.border_depth_m, 1e-9);
        ASSERT_NEAR(border_m + a.tenting_m, b.depth_m, 1e-9);
        ASSERT_NEAR(a.force_before_n, b.force_before_n, 1e-9);
        ASSERT_NEAR(a.force_after_n, b.force_after_n, 1e-9);
        if (a.kind == NeedleEventKind::border) held = a;
        if (a.kind == NeedleEventKind::puncture) {
            ASSERT_NO_FATAL_FAILURE(
                expectClosedForm(patient.package().tissues, hand.settings.friction_scale, held, a))
                << "event " << i;
        }
        coverage.punctures += a.kind == NeedleEventKind::puncture;
        coverage.withdrawn += a.kind == NeedleEventKind::withdrawn;
        coverage.pushed += a.kind == NeedleEventKind::border && a.tenting_m > 0.0;
    }
}

TEST(NeedleRandom, SampledEqualsExactForAThousandTables) {
    Coverage coverage;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        patient::Package package = test::makeColumn(randomLayers(random));
        package.tissues = randomTable(random);
        const patient::Patient patient(package);
        compare(patient, {-0.003, 0.0003, 0.0002}, {package.ct.grid.dims.x * 0.0001 - 0.001, 0.0003, 0.0002},
                random, coverage);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(coverage.compared, 100000u);
    EXPECT_GT(coverage.punctures, 1500u);
    EXPECT_GT(coverage.pushed, 100u);
    EXPECT_GT(coverage.withdrawn, 10u);
}

// Half of the blocks are labelled. The tissue of the others depends on CT thresholds and on the track's
// flags. Air and skin come first.
patient::Package randomBlocks(Random& random) {
    constexpr int kBlocks = 14, kVoxels = 3;
    patient::Package package = test::makeColumn({{Tissue::skin, 0.001}});
    Grid grid{Index3(kBlocks * kVoxels), {0.0013, 0.0009, 0.0011}, Vec3(0.0)};
    package.ct = CtVolume(grid, -1000);
    package.labels = LabelVolume(grid);
    constexpr std::int16_t kHu[] = {-1000, -300, -50, 60, 250, 700};
    for (int b = 0; b < kBlocks * kBlocks * kBlocks; ++b) {
        const bool labelled = below(random, 2) == 0;
        int id = 1 + below(random, patient::kTissueCount - 1);
        if (Tissue(id) == Tissue::bone && below(random, 8) != 0) id = int(Tissue::liver);
        std::int16_t hu = kHu[below(random, 5)];
        if (hu == 250 && below(random, 4) != 0) hu = 60;
        for (int v = 0; v < kVoxels * kVoxels * kVoxels; ++v) {
            const Index3 i{b % kBlocks * kVoxels + v % kVoxels,
                           b / kBlocks % kBlocks * kVoxels + v / kVoxels % kVoxels,
                           b / kBlocks / kBlocks * kVoxels + v / kVoxels / kVoxels};
            package.labels[i] = labelled ? std::uint8_t(id) : std::uint8_t(0);
            package.ct[i] = hu;
        }
    }
    return package;
}

// HZ-TEACH-02
TEST(NeedleRandom, SampledEqualsExactAlongObliquePathsThroughVoxels) {
    Coverage coverage;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        patient::Package package = randomBlocks(random);
        if (seed % 2 == 0) package.tissues = randomTable(random);
        const patient::Patient patient(package);
        const auto anywhere = [&] { return uniform(random, 0.005, 0.033); };
        compare(patient, {-0.005, anywhere(), anywhere()}, {0.050, anywhere(), anywhere()}, random, coverage);
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(coverage.compared, 30000u);
    EXPECT_GT(coverage.punctures, 300u);
}

// HZ-FORCE-01
TEST(NeedleRandom, RandomMotionKeepsTheForceFiniteAndBounded) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        Random random(seed);
        patient::Package package = test::makeColumn(randomLayers(random));
        test::addBreathing(package, 0.015);
        const patient::Patient patient(package);
        Hand hand(patient);
        Vec3 tip{-0.003, 0.0, 0.0};
        for (int i = 0; i < 5000; ++i) {
            tip += Vec3(uniform(random, -0.0002, 0.0003), uniform(random, -0.0003, 0.0003),
                        uniform(random, -0.0003, 0.0003));
            if (tip.x > 0.04) tip.x = -0.003;
            const Vec3 axis{1.0, uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3)};
            hand.axis = axis / std::sqrt(glm::dot(axis, axis));
            hand.breath = {uniform(random, 0.0, 1.0), 0.0};
            hand.to(tip);
            ASSERT_LE(std::fabs(hand.force()), hand.settings.max_force_n) << seed << ' ' << i;
            ASSERT_LE(glm::dot(hand.state.lateral_m, hand.state.lateral_m), 0.00334 * 0.00334);
            ASSERT_TRUE(hand.state.phase != Phase::outside || hand.force() == 0.0);
        }
    }
}

// Skin first, then random layers without air and skin.
test::Layers randomTorso(Random& random) {
    constexpr Tissue kInside[] = {Tissue::soft,   Tissue::fascia, Tissue::liver,
                                  Tissue::vessel, Tissue::duct,   Tissue::soft};
    test::Layers layers{{Tissue::skin, 0.0001 * (1 + below(random, 30))}};
    for (int i = 0; i < 10; ++i)
        layers.push_back({kInside[below(random, 6)], 0.0001 * (1 + below(random, 40))});
    return layers;
}

// The same CT without the labels of skin and soft tissue. Behind the first fascia or liver, soft tissue has
// values that would be bone in front of it.
patient::Package withoutSkinAndSoft(patient::Package package) {
    bool past_fascia = false;
    for (int i = 0; i < package.labels.grid.dims.x; ++i) {
        const Tissue tissue = Tissue(package.labels[{i, 0, 0}]);
        past_fascia = past_fascia || tissue == Tissue::fascia || tissue == Tissue::liver;
        if (tissue != Tissue::skin && tissue != Tissue::soft) continue;
        for (std::size_t row = std::size_t(i); row < package.labels.voxels.size();
             row += std::size_t(package.labels.grid.dims.x)) {
            package.ct.voxels[row] = tissue == Tissue::skin ? -300 : past_fascia ? 250 : 60;
            package.labels.voxels[row] = 0;
        }
    }
    return package;
}

// The needle moves back and forth across borders whose tissue the thresholds find with the track's flags. The
// force is bit-identical to that of the labelled patient.
TEST(NeedleRandom, ThresholdsGiveTheForceOfTheLabelsInAnyMotion) {
    int reversals = 0, left = 0;
    for (std::uint64_t seed = 1; seed <= 500; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        patient::Package labelled = test::makeColumn(randomTorso(random));
        if (seed % 2 == 0) labelled.tissues = randomTable(random);
        const patient::Package partial = withoutSkinAndSoft(labelled);
        const patient::Patient full_patient(labelled), partial_patient(partial);
        Hand full(full_patient), thresholds(partial_patient);
        double x_m = -0.001, goal_m = x_m;
        for (int i = 0; i < 3000; ++i) {
            if (x_m == goal_m) {  // a voxel border, or anywhere
                goal_m = uniform(random, -0.002, 0.020);
                if (below(random, 2) == 0) goal_m = 0.0001 * std::round(goal_m / 0.0001);
                ++reversals;
            }
            const double step_m = uniform(random, 0.0, 0.0004);
            x_m = goal_m > x_m ? std::min(goal_m, x_m + step_m) : std::max(goal_m, x_m - step_m);
            full.to(x_m), thresholds.to(x_m);
            ASSERT_EQ(full.force(), thresholds.force()) << i;
            ASSERT_EQ(full.state.tissue, thresholds.state.tissue) << i;
            ASSERT_EQ(full.events.size(), thresholds.events.size()) << i;
            left += full.state.phase == Phase::outside;
        }
    }
    EXPECT_GT(reversals, 5000);
    EXPECT_GT(left, 1000);
}

}  // namespace
}  // namespace stylet::haptics
