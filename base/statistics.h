// Mean, standard deviation, median and quantiles of a list of values. There are two rules for a quantile:
// quantile() interpolates between neighbours, lowerQuantile() returns one of the values. Their results
// differ, so do not exchange one for the other.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace stylet {

// Arithmetic mean, summed in the order of the values. NaN for no values.
inline double mean(std::span<const double> values) {
    double sum = 0.0;
    for (const double v : values)
        sum += v;
    return sum / double(values.size());
}

// Sample standard deviation (divided by n - 1) about `mean`. 0 for fewer than two values.
inline double sampleDeviation(std::span<const double> values, double mean) {
    if (values.size() < 2) return 0.0;
    double squares = 0.0;
    for (const double v : values)
        squares += (v - mean) * (v - mean);
    return std::sqrt(squares / double(values.size() - 1));
}

// Interpolates linearly between neighbours (type 7 of Hyndman and Fan). NaN values are ignored. NaN for no
// values. Infinite values sort as the smallest and largest.
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

// quantile() at one half: the mean of the two middle values if their number is even.
inline double median(const std::vector<double>& values) {
    return quantile(values, 0.5);
}

// Rank of lowerQuantile() among `count` sorted values: share * (count - 1), rounded down. `share` is in
// [0, 1] and `count` is above 0.
inline std::size_t lowerRank(std::size_t count, double share) {
    assert(count > 0);
    return std::size_t(share * double(count - 1));
}

// The value at lowerRank(). No value may be NaN. 0 for no values.
template <typename T>
T lowerQuantile(std::vector<T> values, double share) {
    if (values.empty()) return T{};
    const auto nth = values.begin() + std::ptrdiff_t(lowerRank(values.size(), share));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

// The value at rank n / 2: the upper one of the two middle values if their number is even. No value may be
// NaN. 0 for no values.
template <typename T>
T upperMedian(std::vector<T> values) {
    if (values.empty()) return T{};
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace stylet
