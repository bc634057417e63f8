// The cubic 3 t^2 - 2 t^3, which rises from 0 to 1 with slope 0 at both ends.
#pragma once

#include <algorithm>

namespace stylet {

// `t` is in [0, 1]; it is not clamped.
constexpr double smoothStep(double t) noexcept {
    return t * t * (3.0 - 2.0 * t);
}

// 0 at `from`, 1 at `to` and constant beyond them. `from` may be greater than `to`.
constexpr double smoothStep(double from, double to, double x) noexcept {
    return smoothStep(std::clamp((x - from) / (to - from), 0.0, 1.0));
}

}  // namespace stylet
