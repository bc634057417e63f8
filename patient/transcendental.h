// exp, sin and cos with the same last bit on every machine: glibc's differ with and without FMA hardware, and
// whatever is hashed must not. Only +, -, *, / and floor are used. Accurate to 2 ulp on the stated ranges.
#pragma once

namespace stylet::patient {

double detExp(double x) noexcept;        // |x| <= 700
double detSin(double radians) noexcept;  // |x| <= 1e6
double detCos(double radians) noexcept;  // |x| <= 1e6

}  // namespace stylet::patient
