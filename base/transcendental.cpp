// Argument reduction in two doubles after Cody and Waite, "Software Manual for the Elementary Functions"
// (1980); the kernels are Taylor polynomials long enough that their tails vanish below half an ulp.
#include "base/transcendental.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace stylet {
namespace {

struct TwoDoubles {
    double high, low;
};

// a + b without rounding error (Knuth).
TwoDoubles twoSum(double a, double b) noexcept {
    const double sum = a + b;
    const double b_part = sum - a;
    return {sum, (a - (sum - b_part)) + (b - b_part)};
}

// The parts have 33 bits or fewer, so n times a part is exact for |n| < 2^20.
struct Reduced {
    double high, low;  // x - n pi/2, in [-pi/4, pi/4]
    double quadrant;   // n modulo 4
};

Reduced reduceByHalfPi(double x) noexcept {
    const double n = std::floor(x * 0x1.45f306dc9c883p-1 + 0.5);
    const TwoDoubles first = twoSum(x, -n * 0x1.921fb544p+0);
    const TwoDoubles second = twoSum(first.high, -n * 0x1.0b4611a6p-34);
    const TwoDoubles third = twoSum(second.high, -n * 0x1.3198a2ep-69);
    const double rest = ((first.low + second.low) + third.low) - n * 0x1.b839a252049c1p-104;
    const TwoDoubles r = twoSum(third.high, rest);
    return {r.high, r.low, n - 4.0 * std::floor(n * 0.25)};
}

// The polynomial in x with these coefficients, highest power first.
template <typename... Rest>
double horner(double x, double first, Rest... rest) noexcept {
    double sum = first;
    ((sum = sum * x + rest), ...);
    return sum;
}

// sin(h + l) for |h| <= pi/4 and l below an ulp of h.
double sinKernel(double h, double l) noexcept {
    const double z = h * h;
    const double p = horner(z, 1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0,
                            -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0);
    return h + (h * z * p + l * (1.0 - 0.5 * z));
}

// cos(h + l): the rounding error of 1 - z/2 is recovered and added with the tail.
double cosKernel(double h, double l) noexcept {
    const double z = h * h;
    const double p = horner(z, -1.0 / 6402373705728000.0, 1.0 / 20922789888000.0, -1.0 / 87178291200.0,
                            1.0 / 479001600.0, -1.0 / 3628800.0, 1.0 / 40320.0, -1.0 / 720.0, 1.0 / 24.0);
    const double half_z = 0.5 * z;
    const double head = 1.0 - half_z;
    return head + (((1.0 - head) - half_z) + (z * z * p - h * l));
}

}  // namespace

double detExp(double x) noexcept {
    if (x > 709.0) return std::numeric_limits<double>::infinity();
    if (x < -708.0) return 0.0;
    if (!(x == x)) return x;
    // x = n ln 2 + r with |r| <= ln(2)/2; the first part of ln 2 has 32 bits, so n times it is exact.
    const double n = std::floor(x * 0x1.71547652b82fep+0 + 0.5);
    const TwoDoubles r = twoSum(x - n * 0x1.62e42feep-1, -n * 0x1.a39ef35793c76p-33);
    const double h = r.high;
    const double p = horner(h, 1.0 / 87178291200.0, 1.0 / 6227020800.0, 1.0 / 479001600.0, 1.0 / 39916800.0,
                            1.0 / 3628800.0, 1.0 / 362880.0, 1.0 / 40320.0, 1.0 / 5040.0, 1.0 / 720.0,
                            1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5);
    const double mantissa = 1.0 + (h + (h * h * p + r.low * (1.0 + h)));
    // |n| <= 1023, so the scale is a normal number.
    return mantissa * std::bit_cast<double>(std::uint64_t(std::int64_t(n) + 1023) << 52);
}

double detSin(double radians) noexcept {
    const Reduced r = reduceByHalfPi(radians);
    if (r.quadrant == 1.0) return cosKernel(r.high, r.low);
    if (r.quadrant == 2.0) return -sinKernel(r.high, r.low);
    if (r.quadrant == 3.0) return -cosKernel(r.high, r.low);
    return sinKernel(r.high, r.low);
}

double detCos(double radians) noexcept {
    const Reduced r = reduceByHalfPi(radians);
    if (r.quadrant == 1.0) return -sinKernel(r.high, r.low);
    if (r.quadrant == 2.0) return -cosKernel(r.high, r.low);
    if (r.quadrant == 3.0) return sinKernel(r.high, r.low);
    return cosKernel(r.high, r.low);
}

}  // namespace stylet
