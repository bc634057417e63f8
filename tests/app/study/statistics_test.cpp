#include "app/study/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::study {
namespace {

using patient::Tissue;

TEST(StudyStatistics, SpreadOfKnownValues) {
    // 1 to 11 and one outlier.
    const Spread s = computeSpread({7, 3, 100, 1, 2, 4, 5, 6, 8, 9, 10, 11, kNone});
    EXPECT_EQ(s.count, 12u);
    EXPECT_NEAR(s.mean, 166.0 / 12.0, 1e-12);
    EXPECT_EQ(s.median, 6.5);
    EXPECT_EQ(s.lower_quartile, 3.75);
    EXPECT_EQ(s.upper_quartile, 9.25);
    EXPECT_EQ(s.lower_whisker, 1.0);
    EXPECT_EQ(s.upper_whisker, 11.0);
    EXPECT_EQ(s.min, 1.0);
    EXPECT_EQ(s.max, 100.0);
    EXPECT_NEAR(s.sigma, 27.319, 0.001);
    EXPECT_NEAR(s.outlier_limit, s.mean + 2.7 * s.sigma, 1e-12);
    EXPECT_NEAR(s.outlier_share, 1.0 / 12.0, 1e-12);
    EXPECT_NEAR(s.above_whisker_share, 1.0 / 12.0, 1e-12);
    // Beyond the whisker but within 2.7 sigma.
    EXPECT_EQ(computeSpread({1, 2, 2, 2, 3, 6}).outlier_share, 0.0);
    EXPECT_NEAR(computeSpread({1, 2, 2, 2, 3, 6}).above_whisker_share, 1.0 / 6.0, 1e-12);
    EXPECT_EQ(computeSpread({1, 2, 3}).above_whisker_share, 0.0);
    EXPECT_EQ(computeSpread({2.0, 2.0}).sigma, 0.0);
    EXPECT_TRUE(std::isnan(computeSpread({2.0}).sigma)) << "the deviation of a single value is undefined";
    EXPECT_TRUE(std::isnan(computeSpread({2.0}).outlier_limit));
    EXPECT_EQ(computeSpread({2.0}).outlier_share, 0.0);
    EXPECT_TRUE(std::isnan(computeSpread({kNone}).mean));
    EXPECT_EQ(computeSpread({}).count, 0u);
}

PathResult path(double rmse_n, double max_n, Tissue cause) {
    PathResult r;
    r.samples = 1000;
    r.sampled = {rmse_n, max_n, 0.02, 0.9};
    r.position_n2[3] = 1000.0 * rmse_n * rmse_n;
    r.sum_n2[std::size_t(cause)] = r.position_n2[3];
    r.event_m.fill(kNone);
    r.cause = {Model::partial, cause, haptics::NeedleEventKind::border, 0.001};
    r.same_order = r.same_order_inside = r.same_order_noticeable = true;
    return r;
}

TEST(StudyStatistics, SummaryOfManyPaths) {
    std::vector<PathResult> results(199, path(0.1, 0.7, Tissue::fascia));
    results.push_back(path(0.4, 1.8, Tissue::duct));
    results[0].event_m[std::size_t(Tissue::duct)] = -0.003;
    results[1].event_m[std::size_t(Tissue::duct)] = 0.001;
    results[2].by_tissue[std::size_t(Tissue::duct)].missed = 1;
    results[2].borders.missed = 2, results[6].borders.missed = 1, results[6].borders.invented = 1;
    results[3].meets_bone = true;
    results[4].borders.mean_m = 0.0021, results[4].borders.hausdorff_m = 0.0029;
    results[5].same_order = false;
    results[7].same_order = results[7].same_order_inside = false;
    results[8].same_order_noticeable = false;
    const Summary s = summarise("some", results);
    EXPECT_EQ(s.paths, 200u);
    EXPECT_EQ(s.samples, 200'000u);
    EXPECT_NEAR(s.rmse_n.mean, 0.1015, 1e-12);
    EXPECT_NEAR(s.pooled_rmse_n, std::sqrt((199 * 0.01 + 0.16) / 200.0), 1e-12);
    EXPECT_NEAR(s.position_rmse_n[3], s.pooled_rmse_n * std::sqrt(double(kPositionBins)), 1e-12);
    EXPECT_EQ(s.position_rmse_n[4], 0.0);
    EXPECT_NEAR(s.max_n.outlier_share, 0.005, 1e-12);
    EXPECT_NEAR(s.rmse_noticed_share, 0.005, 1e-12);
    EXPECT_NEAR(s.distance_noticed_share, 0.005, 1e-12);
    EXPECT_EQ(s.hausdorff_noticed_share, 0.0);
    EXPECT_NEAR(s.same_order_share, 0.99, 1e-12);
    EXPECT_NEAR(s.same_order_inside_share, 0.995, 1e-12);
    EXPECT_NEAR(s.same_order_noticeable_share, 0.995, 1e-12);
    EXPECT_EQ(s.missed_paths, 2u);
    EXPECT_EQ(s.invented_paths, 1u);
    EXPECT_EQ(s.bone_paths, 1u);
    ASSERT_EQ(s.causes.size(), 2u);
    EXPECT_EQ(s.causes[0].cause.tissue, Tissue::fascia);
    EXPECT_EQ(s.causes[0].paths, 199u);
    EXPECT_EQ(s.causes[0].cause.offset_m, 0.001);
    ASSERT_EQ(s.outlier_causes.size(), 1u);
    EXPECT_EQ(s.outlier_causes[0].cause.tissue, Tissue::duct);
    const TissueSummary& duct = s.tissues[std::size_t(Tissue::duct)];
    EXPECT_EQ(duct.missed, 1u);
    EXPECT_NEAR(duct.event_error_m.median, 0.002, 1e-12);
    EXPECT_NEAR(duct.event_offset_m, -0.001, 1e-12);
    EXPECT_NEAR(duct.error_share, 0.16 / (199 * 0.01 + 0.16), 1e-12);
    EXPECT_EQ(summarise("none", {}).paths, 0u);

    const std::vector<Summary> patients{s, s};
    EXPECT_NEAR(computeCohort(patients).rmse_n.mean, s.rmse_n.mean, 1e-12);
    EXPECT_EQ(computeCohort(patients).rmse_n.sigma, 0.0);
}

}  // namespace
}  // namespace stylet::study
