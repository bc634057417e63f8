#include "app/training/learning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stylet::training {
namespace {

// Computed by hand for p0 = 0.1 and p1 = 0.2: P = ln 2, Q = ln(0.9 / 0.8), s = Q / (P + Q) = 0.1452. With
// alpha = beta = 0.1, both limits are ln 9 / (P + Q) = 2.7095. The values agree with the published tables
// (Kestin, Br. J. Anaesth. 75:805, 1995).
TEST(Cusum, LimitsAsInTheTextbook) {
    const CusumLimits limits = cusumLimits({0.1, 0.2, 0.1, 0.1});
    EXPECT_NEAR(limits.step, 0.1452, 5e-5);
    EXPECT_NEAR(limits.lower_h, 2.7095, 5e-5);
    EXPECT_NEAR(limits.upper_h, 2.7095, 5e-5);
}

TEST(Cusum, ErrorRatesMoveTheirLimits) {
    const CusumLimits strict = cusumLimits({0.1, 0.2, 0.01, 0.2}), even = cusumLimits({0.1, 0.2, 0.1, 0.1});
    EXPECT_GT(strict.upper_h, even.upper_h);
    EXPECT_LT(strict.lower_h, even.lower_h);
}

TEST(Cusum, FailuresClimbAndSuccessesDescendToAVerdict) {
    const CusumSettings settings{0.1, 0.2, 0.1, 0.1};
    const CusumLimits limits = cusumLimits(settings);
    const auto at_first = std::size_t(std::ceil(limits.lower_h / limits.step));  // 19 successes in a row
    ASSERT_EQ(at_first, 19u);
    const std::vector<CusumPoint> good = cusum(std::vector<bool>(40, false), settings);
    for (std::size_t i = 0; i < good.size(); ++i) {
        EXPECT_NEAR(good[i].height, -double(i + 1) * limits.step, 1e-12);
        EXPECT_EQ(good[i].verdict, (i + 1) % at_first == 0 ? Verdict::competent : Verdict::open) << i;
    }
    const std::vector<CusumPoint> bad = cusum(std::vector<bool>(4, true), settings);
    EXPECT_EQ(bad[2].verdict, Verdict::open);
    EXPECT_EQ(bad[3].verdict, Verdict::notYet);  // 4 * 0.8548 > 2.7095 > 3 * 0.8548
    EXPECT_TRUE(cusum({}, settings).empty());
}

TEST(LearningCurve, RecoversTheGeneratingParameters) {
    LearningCurve law;
    law.plateau = 92.0, law.gain = 50.0, law.rate = 6.0;
    std::vector<double> totals;
    for (std::size_t i = 0; i < 24; ++i)
        totals.push_back(law.at(i) + (i % 2 == 0 ? 0.5 : -0.5));
    const auto fit = learningCurve(totals);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->plateau, 92.0, 1.0);
    EXPECT_NEAR(fit->gain, 50.0, 1.5);
    EXPECT_NEAR(fit->rate, 6.0, 0.5);
    EXPECT_NEAR(fit->rms, 0.5, 0.05);
    EXPECT_TRUE(fit->supported);
}

TEST(LearningCurve, NeedsFourDifferentTotals) {
    EXPECT_FALSE(learningCurve(std::vector<double>{10, 20, 30}));
    EXPECT_FALSE(learningCurve(std::vector<double>{50, 50, 50, 50, 50}));
    EXPECT_FALSE(learningCurve(std::vector<double>{50, 60, std::nan(""), 70, 80}));
    const auto worse = learningCurve(std::vector<double>{80, 60, 50, 45, 43, 42});
    ASSERT_TRUE(worse);
    EXPECT_LT(worse->gain, 0.0) << "who gets worse has no gain";
}

// Five totals fit three parameters too well, and a curve through noise says nothing.
TEST(LearningCurve, IsNotSupportedByFewOrScatteredTotals) {
    EXPECT_FALSE(learningCurve(std::vector<double>{40, 60, 70, 75, 77.5})->supported);
    EXPECT_TRUE(learningCurve(std::vector<double>{20, 45, 58, 66, 69, 72, 71, 73})->supported);
    std::vector<double> noise;
    for (unsigned i = 0, state = 1; i < 60; ++i)
        noise.push_back(20.0 + double((state = state * 1664525u + 1013904223u) >> 16) / 65536.0 * 70.0);
    const auto fit = learningCurve(noise);
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->supported) << fit->rms;
}

TEST(Percentile, TiesCountHalf) {
    const std::vector<double> cohort{40, 60, 60, 80};
    EXPECT_DOUBLE_EQ(*percentileRank(cohort, 30), 0.0);
    EXPECT_DOUBLE_EQ(*percentileRank(cohort, 60), 0.5);
    EXPECT_DOUBLE_EQ(*percentileRank(cohort, 70), 0.75);
    EXPECT_DOUBLE_EQ(*percentileRank(cohort, 90), 1.0);
    EXPECT_FALSE(percentileRank({}, 50));
    EXPECT_FALSE(percentileRank(cohort, std::numeric_limits<double>::quiet_NaN()));
}

}  // namespace
}  // namespace stylet::training
