#include "patient/synth/random.h"

#include <gtest/gtest.h>

namespace stylet::patient::synth {
namespace {

TEST(Random, IsAFunctionOfSeedStreamAndCount) {
    Random a(7, 1), b(7, 1), other_stream(7, 2), other_seed(8, 1);
    const std::uint64_t first = a.bits();
    EXPECT_EQ(first, b.bits());
    EXPECT_NE(first, other_stream.bits());
    EXPECT_NE(first, other_seed.bits());
    EXPECT_NE(first, a.bits());
}

TEST(Random, UnitIsUniform) {
    Random random(1, 1);
    double sum = 0.0, squares = 0.0;
    constexpr int kDraws = 100000;
    for (int i = 0; i < kDraws; ++i) {
        const double u = random.unit();
        ASSERT_GE(u, 0.0);
        ASSERT_LT(u, 1.0);
        sum += u;
        squares += u * u;
    }
    EXPECT_NEAR(sum / kDraws, 0.5, 0.005);
    EXPECT_NEAR(squares / kDraws, 1.0 / 3.0, 0.005);
}

TEST(ValueNoise, IsContinuousBoundedAndCentred) {
    double sum = 0.0;
    int n = 0;
    for (double x = -20.0; x < 20.0; x += 0.37, ++n) {
        const Vec3 p{x, 2.0 * x, 3.3 - x};
        const double here = valueNoise(p, 5);
        sum += here;
        EXPECT_LE(std::fabs(here), 1.0);
        EXPECT_NEAR(valueNoise(p + Vec3(1e-6), 5), here, 1e-4);
    }
    EXPECT_NEAR(sum / n, 0.0, 0.15);
    EXPECT_NE(valueNoise({0.5, 0.5, 0.5}, 1), valueNoise({0.5, 0.5, 0.5}, 2));
}

}  // namespace
}  // namespace stylet::patient::synth
