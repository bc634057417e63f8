#include "app/study/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/app/study/pairs.h"

namespace stylet::study {
namespace {

using patient::Tissue;

std::size_t at(Tissue t) {
    return std::size_t(t);
}

struct Measured {
    Measured(double full_fascia_m, double partial_fascia_m, SteeringSettings settings = {},
             FoundLabels labels = FoundLabels::partial)
        : pair(test::slabPair(full_fascia_m, partial_fascia_m, labels)),
          prepared(pair),
          steering(prepared, settings),
          steered(steering.steer(test::slabPath())),
          result(measure(*steered)) {}
    const Pair pair;
    const PreparedPair prepared;
    Steering steering;
    const SteeringResult* steered;
    PathResult result;
};

PathResult measurePair(const Pair& pair) {
    const PreparedPair prepared(pair);
    Steering steering(prepared, {});
    return measure(*steering.steer(test::slabPath()));
}

TEST(StudyMetrics, EqualSegmentationsGiveEqualForces) {
    for (const FoundLabels labels : {FoundLabels::partial, FoundLabels::all}) {
        const PathResult r = Measured(0.020, 0.020, {}, labels).result;
        EXPECT_EQ(r.sampled.rmse_n, 0.0);
        EXPECT_EQ(r.sampled.equal_share, 1.0);
        EXPECT_EQ(r.exact.max_n, 0.0);
        EXPECT_NEAR(r.exact.equal_share, 1.0, 1e-12);
        EXPECT_TRUE(r.same_order && r.same_order_noticeable);
        EXPECT_EQ(r.cause.model, Model::neither);
        EXPECT_EQ(r.borders.hausdorff_m, 0.0);
        EXPECT_EQ(r.borders.missed + r.borders.invented, 0);
        EXPECT_EQ(r.samples, 1000u);
        EXPECT_NEAR(r.travel_m, 0.063, 1e-12);  // from the skin's surface
    }
}

// The partial patient's fascia is 1 mm too deep, so its tenting and its puncture come 1 mm later. Just after
// the full patient's puncture the forces are 0.9 N (full) and 2.5 N (partial). Just before it they are 2.5 N
// (full) and f(0.8 mm) (partial).
TEST(StudyMetrics, DisplacedFasciaMatchesClosedForm) {
    const PathResult r = Measured(0.020, 0.021).result;
    EXPECT_NEAR(r.exact.max_n, 1.6, 1e-9);
    EXPECT_NEAR(r.exact.max_at_m, 0.0228 - 0.00025, 1e-9);
    EXPECT_NEAR(r.sampled.max_n, 1.6, 0.1);
    EXPECT_LE(r.sampled.max_n, r.exact.max_n);
    EXPECT_NEAR(r.exact.equal_share, 1.0 - 0.0028 / 0.063, 1e-9);
    EXPECT_NEAR(r.sampled.equal_share, r.exact.equal_share, 0.002);
    EXPECT_TRUE(r.same_order);
    EXPECT_FALSE(r.meets_bone);
    EXPECT_NEAR(r.event_m[at(Tissue::fascia)], 0.001, 1e-12);
    EXPECT_EQ(r.event_m[at(Tissue::duct)], 0.0);
    EXPECT_NEAR(r.by_tissue[at(Tissue::fascia)].mean_m, 0.0005, 1e-12);  // mean of 1, 0, 0 and 1 mm
    EXPECT_NEAR(r.by_tissue[at(Tissue::fascia)].hausdorff_m, 0.001, 1e-12);
    EXPECT_NEAR(r.by_tissue[at(Tissue::liver)].mean_m, 0.0005, 1e-12);
    EXPECT_EQ(r.by_tissue[at(Tissue::skin)].mean_m, 0.0);
    EXPECT_NEAR(r.borders.hausdorff_m, 0.001, 1e-12);
    EXPECT_TRUE(std::isnan(r.event_m[at(Tissue::bone)]));

    EXPECT_EQ(r.cause.model, Model::full);
    EXPECT_EQ(r.cause.tissue, Tissue::fascia);
    EXPECT_EQ(r.cause.kind, haptics::NeedleEventKind::border);
    EXPECT_NEAR(r.cause.offset_m, 0.001, 1e-12);
    // All of the error lies within 2 mm of an event.
    EXPECT_EQ(r.max_outside_n, 0.0);
    EXPECT_GT(measure(*Measured(0.020, 0.021).steered, {0.0001}).max_outside_n, 1.0);
}

TEST(StudyMetrics, ManySamplesConvergeToClosedForm) {
    SteeringSettings fine;
    fine.samples = 2'000'000;
    const PathResult r = Measured(0.020, 0.0235, fine).result;
    EXPECT_GT(r.exact.rmse_n, 0.1);
    EXPECT_NEAR(r.sampled.rmse_n, r.exact.rmse_n, 1e-6);
    EXPECT_NEAR(r.sampled.max_n, r.exact.max_n, 1e-4);
    EXPECT_NEAR(r.sampled.equal_share, r.exact.equal_share, 1e-5);
    double by_place = 0.0, by_tissue = 0.0;
    for (const double n2 : r.position_n2)
        by_place += n2;
    for (const double n2 : r.sum_n2)
        by_tissue += n2;
    const double all = r.sampled.rmse_n * r.sampled.rmse_n * r.samples;
    EXPECT_NEAR(by_place, all, 1e-9 * all);
    EXPECT_NEAR(by_tissue, all, 1e-9 * all);
    // The middle third of the path contains the fascia's errors.
    EXPECT_NEAR(r.position_n2[6] + r.position_n2[7] + r.position_n2[8], all, 0.05 * all);
}

TEST(StudyMetrics, FalseBoneStopsTheNeedle) {
    Pair pair = test::slabPair(0.020, 0.020);
    const Index3 place = pair.found.ct.grid.nearest({0.0402, 0.0, 0.0});
    pair.found.labels[place] = 0;
    pair.found.ct[place] = 900;
    const PathResult r = measurePair(pair);
    EXPECT_TRUE(r.meets_bone);
    EXPECT_NEAR(r.sampled.max_n, 22.0 - 0.5, 1e-9);  // at the target, in the full patient's duct
    EXPECT_EQ(r.cause.tissue, Tissue::bone);
    EXPECT_EQ(r.cause.model, Model::partial);
    EXPECT_TRUE(std::isnan(r.cause.offset_m));
    EXPECT_EQ(r.by_tissue[at(Tissue::bone)].invented, 1);
    EXPECT_EQ(r.by_tissue[at(Tissue::duct)].missed, 0);  // the border exists; the needle does not reach it
    EXPECT_FALSE(r.same_order);
}

// 3 mm of cartilage that only the built patient has, in front of the duct: the needle cuts it.
TEST(StudyMetrics, FalseCartilageDoesNotStopTheNeedle) {
    Pair pair = test::slabPair(0.020, 0.020, FoundLabels::all);
    const Grid& g = pair.found.ct.grid;
    forEachVoxel(g, [&](const Index3& i) {
        const double x_m = g.centre(i).x;
        if (x_m > 0.036 && x_m < 0.039) pair.found.labels[i] = std::uint8_t(Tissue::cartilage);
    });
    const PathResult r = measurePair(pair);
    EXPECT_FALSE(r.meets_bone);
    const double liver_friction_n = test::tissueDefaults().tissues[std::size_t(Tissue::liver)].friction_n;
    EXPECT_NEAR(r.sampled.max_n, 2.8 - liver_friction_n, 0.02);
    EXPECT_EQ(r.by_tissue[at(Tissue::cartilage)].invented, 1);
    EXPECT_EQ(r.by_tissue[at(Tissue::duct)].missed, 0);
}

// In the built patient, the skin is labelled as soft tissue. The needle punctures soft tissue directly from
// the air.
TEST(StudyMetrics, MissedSkinChangesTheOrderOnlyAtTheSkin) {
    Pair pair = test::slabPair(0.020, 0.020, FoundLabels::all);
    for (std::uint8_t& id : pair.found.labels.voxels)
        if (id == std::uint8_t(Tissue::skin)) id = std::uint8_t(Tissue::soft);
    const PathResult r = measurePair(pair);
    EXPECT_EQ(r.by_tissue[at(Tissue::skin)].missed, 1);
    EXPECT_FALSE(r.same_order);
    EXPECT_FALSE(r.same_order_noticeable);
    EXPECT_TRUE(r.same_order_inside);
}

// The built patient's duct begins 3 mm and `gap_m` too early. The gap is at its true beginning.
PathResult measureGap(double gap_m, Tissue between) {
    Pair pair = test::slabPair(0.020, 0.020, FoundLabels::all);
    const Grid& g = pair.found.labels.grid;
    const auto duct = std::uint8_t(Tissue::duct);
    std::vector<std::uint8_t>& labels = pair.found.labels.voxels;
    int first = g.dims.x;
    for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i] == duct) first = std::min(first, int(i % std::size_t(g.dims.x)));
    const int voxels = int(std::lround(gap_m / g.spacing_m.x));
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const int x = int(i % std::size_t(g.dims.x));
        if (x >= first - voxels - 6 && x < first - voxels) labels[i] = duct;
        if (x >= first - voxels && x < first) labels[i] = std::uint8_t(between);
    }
    return measurePair(pair);
}

TEST(StudyMetrics, ShortReentryOfATissueIsNotNoticeable) {
    EXPECT_FALSE(measureGap(0.001, Tissue::liver).same_order);
    EXPECT_TRUE(measureGap(0.001, Tissue::liver).same_order_noticeable);
    EXPECT_FALSE(measureGap(0.003, Tissue::liver).same_order_noticeable);
    EXPECT_FALSE(measureGap(0.001, Tissue::vessel).same_order_noticeable);
    EXPECT_FALSE(measureGap(0.001, Tissue::fascia).same_order_noticeable);
}

struct PaintedLayer {
    Tissue tissue;
    double begin_m, end_m;
};
void paintLayers(LabelVolume& labels, const std::vector<PaintedLayer>& layers) {
    for (const PaintedLayer& layer : layers)
        forEachVoxel(labels.grid, [&](const Index3& i) {
            const double x_m = labels.grid.centre(i).x;
            if (x_m > layer.begin_m && x_m < layer.end_m) labels[i] = std::uint8_t(layer.tissue);
        });
}
// In the reference, the fascia begins at 20 mm, the duct at 61 mm, and the path ends at 63 mm.
PathResult measureLayers(const std::vector<PaintedLayer>& in_both,
                         const std::vector<PaintedLayer>& in_built) {
    Pair pair = test::slabPair(0.020, 0.020, FoundLabels::all);
    paintLayers(pair.reference.labels, in_both);
    paintLayers(pair.found.labels, in_both);
    paintLayers(pair.found.labels, in_built);
    return measurePair(pair);
}
bool agreesIfBuilt(const std::vector<PaintedLayer>& in_built) {
    const PathResult r = measureLayers({}, in_built);
    EXPECT_FALSE(r.same_order);
    return r.same_order_noticeable;
}

// A layer that only one patient has changes the order if it is thick enough to notice, or if it is one that a
// trainee must cross or avoid.
TEST(StudyMetrics, AThinLayerIsNotNoticeableUnlessItMatters) {
    for (const Tissue plain : {Tissue::soft, Tissue::duct}) {
        EXPECT_TRUE(agreesIfBuilt({{plain, 0.040, 0.0415}}));
        EXPECT_FALSE(agreesIfBuilt({{plain, 0.040, 0.0425}}));
        // Two thin layers with hardly anything between them, and two that are far apart.
        EXPECT_FALSE(agreesIfBuilt({{plain, 0.040, 0.0415}, {plain, 0.042, 0.0435}}));
        EXPECT_TRUE(agreesIfBuilt({{plain, 0.040, 0.0415}, {plain, 0.044, 0.0455}}));
    }
    for (const Tissue t : {Tissue::vessel, Tissue::fascia, Tissue::cartilage, Tissue::bone, Tissue::skin})
        EXPECT_FALSE(agreesIfBuilt({{t, 0.040, 0.0415}}));
    // Soft tissue between fascia and liver, and none between skin and fascia.
    EXPECT_TRUE(agreesIfBuilt({{Tissue::soft, 0.021, 0.022}}));
    EXPECT_FALSE(agreesIfBuilt({{Tissue::fascia, 0.002, 0.020}}));
    // The duct that holds the target, as thin as this.
    const std::vector<PaintedLayer> thin{{Tissue::liver, 0.061, 0.0625}, {Tissue::liver, 0.0635, 0.065}};
    EXPECT_TRUE(measureLayers(thin, {}).same_order_noticeable);
    EXPECT_FALSE(measureLayers(thin, {{Tissue::liver, 0.0625, 0.0635}}).same_order_noticeable);
}

// A membrane that is entered again is noticed if it must be punctured again, that is, beyond the reach of the
// cut.
TEST(StudyMetrics, ASecondPunctureOfAMembraneIsNoticeable) {
    EXPECT_TRUE(agreesIfBuilt({{Tissue::liver, 0.0205, 0.021}, {Tissue::fascia, 0.021, 0.0215}}));
    EXPECT_FALSE(agreesIfBuilt({{Tissue::fascia, 0.0225, 0.023}}));
}

TEST(StudyMetrics, AnEntryJustBehindTheTargetCounts) {
    const PaintedLayer none{Tissue::liver, 0.061, 0.065};
    EXPECT_FALSE(agreesIfBuilt({none}));
    EXPECT_TRUE(agreesIfBuilt({none, {Tissue::duct, 0.0645, 0.070}}));
    EXPECT_FALSE(agreesIfBuilt({none, {Tissue::duct, 0.0655, 0.070}}));
    // In the reference, the path leaves the duct behind the target; in the built patient, before it.
    const PathResult early = measureLayers({{Tissue::liver, 0.064, 0.065}}, {{Tissue::liver, 0.0625, 0.064}});
    EXPECT_FALSE(early.same_order);
    EXPECT_TRUE(early.same_order_noticeable);
}

// On paths through a patient, the noticeable order never differs where the exact order does not.
TEST(StudyMetrics, TheSameOrderIsNeverNoticeablyDifferent) {
    const PreparedPair prepared(test::seededPair());
    Steering steering(prepared, {});
    std::size_t same = 0, noticeable = 0;
    for (const patient::PlannedPath& path : test::seededPaths()) {
        const PathResult r = measure(*steering.steer(path));
        EXPECT_LE(r.same_order, r.same_order_noticeable);
        same += r.same_order, noticeable += r.same_order_noticeable;
    }
    EXPECT_GT(same, 0u);
    EXPECT_GT(noticeable, same);
}

// Muscle below fat has another label but the same tissue. The breathing needle reports an event there, and
// the order of the tissues is unchanged.
TEST(StudyMetrics, LabelChangeWithinATissueKeepsTheOrder) {
    Pair pair = test::slabPair(0.020, 0.020);
    constexpr std::uint8_t kMuscle = 20;
    patient::Label muscle = pair.reference.label_table[at(Tissue::soft) - 1];
    ASSERT_EQ(muscle.tissue, Tissue::soft);
    muscle.id = kMuscle, muscle.name = "muscle";
    pair.reference.label_table.push_back(muscle);
    const Grid& grid = pair.reference.labels.grid;
    const auto half = std::size_t(grid.nearest({0.010, 0.0, 0.0}).x);
    std::vector<std::uint8_t>& labels = pair.reference.labels.voxels;
    for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i] == std::uint8_t(Tissue::soft) && i % std::size_t(grid.dims.x) > half)
            labels[i] = kMuscle;
    const PreparedPair prepared(pair);
    SteeringSettings breathing;
    breathing.breathing = true;
    Steering steering(prepared, breathing);
    const SteeringResult& s = *steering.steer(test::slabPath());
    EXPECT_GT(s.full.force->events.size(), s.partial.force->events.size());
    EXPECT_TRUE(measure(s).same_order);
}

TEST(StudyMetrics, MissedDuctIsReportedAsMissed) {
    Pair pair = test::slabPair(0.020, 0.020);
    for (std::uint8_t& id : pair.found.labels.voxels)
        if (id == std::uint8_t(Tissue::duct)) id = std::uint8_t(Tissue::liver);
    const PathResult r = measurePair(pair);
    EXPECT_EQ(r.by_tissue[at(Tissue::duct)].missed, 1);
    EXPECT_FALSE(r.same_order_inside);
    EXPECT_EQ(r.borders.missed, 1);
    EXPECT_TRUE(std::isnan(r.by_tissue[at(Tissue::duct)].mean_m));
    EXPECT_TRUE(std::isnan(r.event_m[at(Tissue::duct)]));
    EXPECT_EQ(r.cause.tissue, Tissue::duct);
    EXPECT_EQ(r.cause.model, Model::full);
    EXPECT_NEAR(r.sampled.max_n, 0.4, 1e-9);  // 0.9 in the liver, 0.5 in the duct
}

// A vessel 5 mm below the capsule. The full patient has no vessel at all, or only one far behind the target.
TEST(StudyMetrics, VesselBehindTheTargetIsNotMatched) {
    Pair pair = test::slabPair(0.020, 0.020);
    const Grid& grid = pair.found.ct.grid;
    pair.found.labels[grid.nearest({0.0262, 0.0, 0.0})] = std::uint8_t(Tissue::vessel);
    for (const double behind_m : {0.0, 0.0702}) {
        if (behind_m > 0.0)
            pair.reference.labels[grid.nearest({behind_m, 0.0, 0.0})] = std::uint8_t(Tissue::vessel);
        const PathResult r = measurePair(pair);
        EXPECT_EQ(r.by_tissue[at(Tissue::vessel)].invented, 1);
        EXPECT_EQ(r.by_tissue[at(Tissue::vessel)].missed, 0);
        EXPECT_TRUE(std::isnan(r.by_tissue[at(Tissue::vessel)].mean_m));
        EXPECT_EQ(r.borders.invented, 1);
    }
}

// The needle continues behind the target to find borders that come late. A border that both patients reach
// only behind the target is not an error.
TEST(StudyMetrics, VesselBehindTheTargetInBothIsNoError) {
    Pair pair = test::slabPair(0.020, 0.020);
    const Grid& grid = pair.found.ct.grid;
    const double target_m = test::slabPath().target_reference_m.x;
    pair.reference.labels[grid.nearest({target_m + 0.0040, 0.0, 0.0})] = std::uint8_t(Tissue::vessel);
    pair.found.labels[grid.nearest({target_m + 0.0060, 0.0, 0.0})] = std::uint8_t(Tissue::vessel);
    const PreparedPair prepared(pair);
    Steering steering(prepared, {});
    const SteeringResult& steered = *steering.steer(test::slabPath());
    const auto isVessel = [](const haptics::ExactEvent& e) { return e.tissue == Tissue::vessel; };
    ASSERT_TRUE(std::ranges::any_of(steered.full.force->events, isVessel));
    ASSERT_TRUE(std::ranges::any_of(steered.partial.force->events, isVessel));
    EXPECT_TRUE(std::isnan(measure(steered).event_m[at(Tissue::vessel)]));
}

// A duct that begins 1 mm behind the target is late, not missed.
TEST(StudyMetrics, DuctBehindTheTargetIsLateNotMissed) {
    Pair pair = test::slabPair(0.020, 0.020);
    const Grid& grid = pair.found.ct.grid;
    for (int i = 0; i < 6; ++i)  // from 61 to 64 mm: the duct now starts behind the target
        pair.found.labels[grid.nearest({0.06125 + 0.0005 * i, 0.0, 0.0})] = std::uint8_t(Tissue::liver);
    const PathResult r = measurePair(pair);
    EXPECT_EQ(r.by_tissue[at(Tissue::duct)].missed, 0);
    EXPECT_NEAR(r.by_tissue[at(Tissue::duct)].mean_m, 0.003, 1e-9);
    EXPECT_NEAR(r.event_m[at(Tissue::duct)], 0.003, 1e-9);
}

}  // namespace
}  // namespace stylet::study
