#include "base/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "base/smoothstep.h"

namespace stylet {
namespace {

TEST(Statistics, ComputesMeanAndSampleDeviation) {
    const std::vector<double> values{2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0};
    EXPECT_DOUBLE_EQ(mean(values), 5.0);
    EXPECT_DOUBLE_EQ(sampleDeviation(values, 5.0), std::sqrt(32.0 / 7.0));
    EXPECT_TRUE(std::isnan(mean({})));
    const std::vector<double> one{3.0};
    EXPECT_EQ(sampleDeviation(one, 3.0), 0.0);
}

TEST(Statistics, QuantileInterpolates) {
    EXPECT_DOUBLE_EQ(median({3.0, 1.0, 2.0}), 2.0);
    EXPECT_DOUBLE_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 0.25), 2.5);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, -1.0), 0.0);
    EXPECT_DOUBLE_EQ(quantile({0.0, 10.0}, 2.0), 10.0);
    EXPECT_DOUBLE_EQ(median({1.0, NAN, 3.0}), 2.0);
    EXPECT_TRUE(std::isnan(median({})));
    EXPECT_EQ(quantile({1.0, INFINITY, INFINITY}, 1.0), INFINITY);
}

TEST(Statistics, LowerQuantileIsOneOfTheValues) {
    const std::vector<double> values{4.0, 1.0, 3.0, 2.0};
    EXPECT_EQ(lowerQuantile(values, 0.0), 1.0);
    EXPECT_EQ(lowerQuantile(values, 0.5), 2.0);
    EXPECT_EQ(lowerQuantile(values, 0.99), 3.0);
    EXPECT_EQ(lowerQuantile(values, 1.0), 4.0);
    EXPECT_EQ(lowerQuantile(std::vector<float>{5.0f}, 0.9), 5.0f);
    EXPECT_EQ(lowerQuantile(std::vector<double>{}, 0.5), 0.0);
    EXPECT_EQ(lowerRank(101, 0.99), 99u);
    EXPECT_EQ(lowerRank(4, 0.5), 1u);
}

TEST(Statistics, UpperMedianIsTheUpperOfTwo) {
    EXPECT_EQ(upperMedian(std::vector<double>{4.0, 1.0, 3.0, 2.0}), 3.0);
    EXPECT_EQ(upperMedian(std::vector<double>{3.0, 1.0, 2.0}), 2.0);
    EXPECT_EQ(upperMedian(std::vector<float>{}), 0.0f);
}

TEST(Smoothstep, RisesFromZeroToOne) {
    EXPECT_EQ(smoothStep(0.0), 0.0);
    EXPECT_EQ(smoothStep(0.5), 0.5);
    EXPECT_EQ(smoothStep(1.0), 1.0);
    EXPECT_EQ(smoothStep(2.0, 4.0, 1.0), 0.0);
    EXPECT_EQ(smoothStep(2.0, 4.0, 3.0), 0.5);
    EXPECT_EQ(smoothStep(2.0, 4.0, 5.0), 1.0);
    EXPECT_EQ(smoothStep(4.0, 2.0, 5.0), 0.0);  // falling
    EXPECT_EQ(smoothStep(4.0, 2.0, 1.0), 1.0);
}

}  // namespace
}  // namespace stylet
