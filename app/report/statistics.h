// Quantiles of values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace stylet::report {

// Interpolates linearly between neighbours (type 7 of Hyndman and Fan). NaN for no values. Infinite values
// sort as the smallest and largest.
inline double quantile(std::vector<double> values, double share) {
    std::erase_if(values, [](double v) { return std::isnan(v); });
    if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    const double place = std::clamp(share, 0.0, 1.0) * double(values.size() - 1);
    const auto low = std::size_t(place);
    const std::size_t high = std::min(low + 1, values.size() - 1);
    const double part = place - double(low);
    if (part == 0.0 || values[low] == values[high]) return values[low];
    return values[low] + part * (values[high] - values[low]);
}

inline double median(const std::vector<double>& values) {
    return quantile(values, 0.5);
}

}  // namespace stylet::report
