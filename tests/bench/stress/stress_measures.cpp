#include "tests/bench/stress/stress_measures.h"

#include <algorithm>
#include <cmath>

namespace stylet::stress {

namespace {

// High-pass filter: subtracts the moving mean over one period of kCycle_hz. Faster motion remains.
std::vector<double> withoutSlow(const std::vector<double>& x, double dt_s) {
    const std::size_t half = std::max<std::size_t>(1, std::size_t(0.5 / kCycle_hz / dt_s));
    if (x.size() < 4 * half) return {};
    std::vector<double> sums(x.size() + 1, 0.0);
    for (std::size_t i = 0; i < x.size(); ++i)
        sums[i + 1] = sums[i] + (x[i] - x[0]);
    std::vector<double> fast;
    for (std::size_t i = half; i + half < x.size(); ++i) {
        const double mean = (sums[i + half + 1] - sums[i - half]) / double(2 * half + 1);
        fast.push_back(x[i] - x[0] - mean);
    }
    return fast;
}

// Returns the amplitude of a sine with the same power.
double amplitude(const double* begin, const double* end) {
    double squares = 0.0;
    for (const double* p = begin; p != end; ++p)
        squares += *p * *p;
    return std::sqrt(2.0 * squares / double(end - begin));
}

}  // namespace

Cycle findCycle(const std::vector<double>& position_m, double dt_s, double wide_m) {
    // Filter twice: after one pass, the curvature of the breathing motion within the window still remains.
    const std::vector<double> fast = withoutSlow(withoutSlow(position_m, dt_s), dt_s);
    if (fast.size() < 16) return {};
    const double* const begin = fast.data();
    const double* const end = begin + fast.size();
    const double* const middle = begin + fast.size() / 2;
    Cycle cycle;
    cycle.amplitude_m = amplitude(middle, end);
    int crossings = 0;
    for (const double* p = middle + 1; p != end; ++p)
        crossings += (p[-1] < 0.0) != (*p < 0.0);
    cycle.hz = 0.5 * crossings / (double(end - middle) * dt_s);
    const bool dies_away = cycle.amplitude_m < 0.7 * amplitude(begin, middle);
    cycle.lasts = cycle.amplitude_m > wide_m && cycle.hz > kCycle_hz && !dies_away;
    return cycle;
}

}  // namespace stylet::stress
