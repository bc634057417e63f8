// exp, sin and cos with identical bits on every machine. glibc's results differ with and without FMA
// hardware, which hashed state cannot tolerate. Uses only +, -, *, / and floor. Accurate to 2 ulp on the
// stated ranges.
#pragma once

namespace stylet {

double detExp(double x) noexcept;        // |x| <= 700
double detSin(double radians) noexcept;  // |x| <= 1e6
double detCos(double radians) noexcept;  // |x| <= 1e6

}  // namespace stylet
