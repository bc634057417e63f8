#include "base/transcendental.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace stylet::patient {
namespace {

static_assert(std::numeric_limits<long double>::digits >= 64, "the oracle needs more bits than a double");

double ulpsBetween(double value, long double exact) {
    const double nearest = std::abs(double(exact));
    const double ulp = std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest;
    return double(std::abs(static_cast<long double>(value) - exact) / ulp);
}

template <typename F, typename G>
double worstUlps(F ours, G exact, double low, double high, int count) {
    std::mt19937_64 random(20170712);
    std::uniform_real_distribution<double> uniform(low, high);
    double worst = 0.0;
    for (int i = 0; i < count; ++i) {
        const double x = uniform(random);
        worst = std::max(worst, ulpsBetween(ours(x), exact(static_cast<long double>(x))));
    }
    return worst;
}

long double longExp(long double x) {
    return std::exp(x);
}
long double longSin(long double x) {
    return std::sin(x);
}
long double longCos(long double x) {
    return std::cos(x);
}

TEST(Transcendental, WithinTwoUlps) {
    for (const double range : {1e-6, 0.7, 10.0, 700.0})
        EXPECT_LE(worstUlps(detExp, longExp, -range, range, 200000), 2.0);
    for (const double range : {1e-6, 0.8, 10.0, 1e3, 1e6}) {
        EXPECT_LE(worstUlps(detSin, longSin, -range, range, 200000), 2.0);
        EXPECT_LE(worstUlps(detCos, longCos, -range, range, 200000), 2.0);
    }
}

// Near multiples of pi/2 the sine or cosine is close to zero and cancellation is largest.
TEST(Transcendental, WithinTwoUlpsNearTheZeros) {
    const long double half_pi = std::acos(0.0L);
    for (int n = 1; n < 600000; n += 7) {
        const double x = double(half_pi * n);
        ASSERT_LE(ulpsBetween(detSin(x), std::sin(static_cast<long double>(x))), 2.0) << x;
        ASSERT_LE(ulpsBetween(detCos(x), std::cos(static_cast<long double>(x))), 2.0) << x;
    }
}

TEST(Transcendental, ExactWhereTheyShouldBe) {
    EXPECT_EQ(detExp(0.0), 1.0);
    EXPECT_EQ(detSin(0.0), 0.0);
    EXPECT_EQ(detCos(0.0), 1.0);
    EXPECT_EQ(detExp(1000.0), std::numeric_limits<double>::infinity());
    EXPECT_EQ(detExp(-1000.0), 0.0);
    EXPECT_TRUE(std::isnan(detExp(std::nan(""))));
    EXPECT_TRUE(std::isnan(detSin(std::numeric_limits<double>::infinity())));
    EXPECT_TRUE(std::isnan(detCos(std::nan(""))));
}

// Compares with recorded bits. Every compiler, preset and machine must produce them.
TEST(Transcendental, SameBitsEverywhere) {
    std::uint64_t folded = 0;
    for (int i = -5000; i <= 5000; ++i) {
        const double x = 0.1337 * i;
        for (const double y : {detExp(x), detSin(x), detCos(x)})
            folded = std::rotl(folded, 5) * 0x9e3779b97f4a7c15ull ^ std::bit_cast<std::uint64_t>(y);
    }
    EXPECT_EQ(folded, 5297954650366304627ull);
}

}  // namespace
}  // namespace stylet::patient
