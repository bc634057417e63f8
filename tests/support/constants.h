// Constants that many tests need.
#pragma once

#include <cstdint>
#include <limits>

namespace stylet::test {

inline constexpr double kDt_s = 0.001;  // haptics tick
inline constexpr std::int64_t kTick_ns = 1'000'000;
inline constexpr std::int64_t kMs = 1'000'000;  // one millisecond [ns]
inline constexpr double kMm = 0.001;
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace stylet::test
