#include "app/training/losses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stylet::training {
namespace {

// Every metric at its best.
MetricValues bestValues() {
    MetricValues values;
    for (std::size_t i = 0; i < kMetricCount; ++i)
        values[i] = metricTable()[i].best;
    return values;
}

double& valueOf(MetricValues& values, MetricId id) {
    return values[std::size_t(id)];
}

TEST(Losses, AddUpToThePointsThatAreMissing) {
    MetricValues values = bestValues();
    valueOf(values, MetricId::procedure) = 60.0;
    valueOf(values, MetricId::skinContacts) = 12.0;
    valueOf(values, MetricId::targeting) = std::numeric_limits<double>::quiet_NaN();
    const Score score = computeScore(values, kAllSteps);
    double lost = 0.0;
    for (const MetricLoss& loss : splitLosses(score)) {
        EXPECT_GE(loss.by_value, 0.0);
        EXPECT_GE(loss.by_steps, 0.0);
        lost += loss.by_value + loss.by_steps;
    }
    EXPECT_NEAR(lost, 100.0 - score.total, 1e-9);
}

// The needle never touched a no-go area, and one of six steps was done. Nothing was lost by the no-go areas.
TEST(Losses, AMetricAtItsBestIsNeverBlamed) {
    MetricValues values = bestValues();
    valueOf(values, MetricId::procedure) = 10.0;
    const Score score = computeScore(values, kAllSteps);
    const std::vector<Loss> losses = findLosses(score);
    ASSERT_EQ(losses.size(), 1u);
    EXPECT_FALSE(losses[0].metric);
    EXPECT_NEAR(losses[0].points, 100.0 - score.total, 1e-9);
    const std::string text = describeLoss(losses[0], score, 1, 6);
    EXPECT_NE(text.find("counts only for the part of the procedure that was done: 1 of 6 steps"), text.npos)
        << text;
}

TEST(Losses, AreSortedAndGivenInTheirUnit) {
    MetricValues values = bestValues();
    valueOf(values, MetricId::skinContacts) = 14.0;
    valueOf(values, MetricId::noGoTime) = 5.0;
    valueOf(values, MetricId::needleInBeam) = std::numeric_limits<double>::quiet_NaN();
    const Score score = computeScore(values, kAllSteps);
    const std::vector<Loss> losses = findLosses(score);
    ASSERT_GE(losses.size(), 3u);
    for (std::size_t i = 1; i < losses.size(); ++i)
        EXPECT_GE(losses[i - 1].points, losses[i].points);
    std::string all;
    for (const Loss& loss : losses)
        all += describeLoss(loss, score, 6, 6) + '\n';
    EXPECT_NE(all.find("Time in no-go areas, 5 s (full points up to 0 s)"), all.npos) << all;
    EXPECT_NE(all.find("Skin contacts, 14 (full points up to 5)"), all.npos) << all;
    EXPECT_NE(all.find("Needle in the beam, not achieved"), all.npos) << all;
    EXPECT_EQ(all.find("of 6 steps"), all.npos) << all;
}

// The weights of a drainage are not round: its metrics share 100 points with further ones.
TEST(Losses, PointsHaveFewDigits) {
    MetricValues values = bestValues();
    for (std::size_t i = 0; i < kMetricCount; ++i)
        values[i] = metricTable()[i].worst;
    const Score score = computeScore(values, kAllSteps, Course::drainage);
    const std::vector<Loss> losses = findLosses(score);
    ASSERT_FALSE(losses.empty());
    for (const Loss& loss : losses) {
        const std::string text = describeLoss(loss, score, 12, 12);
        EXPECT_LE(text.find(" points lost"), std::string_view("12.3 of 12.3").size()) << text;
    }
}

TEST(Losses, NoneIsListedIfNothingWasLost) {
    EXPECT_TRUE(findLosses(computeScore(bestValues(), kAllSteps)).empty());
}

}  // namespace
}  // namespace stylet::training
