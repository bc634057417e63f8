#include "app/training/learning.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace stylet::training {

CusumLimits cusumLimits(const CusumSettings& c) noexcept {
    assert(0.0 < c.acceptable && c.acceptable < c.unacceptable && c.unacceptable < 1.0);
    assert(0.0 < c.alpha && 0.0 < c.beta && c.alpha + c.beta < 1.0);
    const double p = std::log(c.unacceptable / c.acceptable);
    const double q = std::log((1.0 - c.acceptable) / (1.0 - c.unacceptable));
    return {q / (p + q), std::log((1.0 - c.alpha) / c.beta) / (p + q),
            std::log((1.0 - c.beta) / c.alpha) / (p + q)};
}

std::vector<CusumPoint> cusum(const std::vector<bool>& failed, const CusumSettings& settings) {
    const CusumLimits limits = cusumLimits(settings);
    std::vector<CusumPoint> points;
    points.reserve(failed.size());
    double height = 0.0, began = 0.0;
    for (const bool failure : failed) {
        height += failure ? 1.0 - limits.step : -limits.step;
        Verdict verdict = Verdict::open;
        if (height - began <= -limits.lower_h) verdict = Verdict::competent;
        if (height - began >= limits.upper_h) verdict = Verdict::notYet;
        if (verdict != Verdict::open) began = height;
        points.push_back({height, verdict});
    }
    return points;
}

double LearningCurve::at(std::size_t attempt) const noexcept {
    return plateau - gain * std::exp(-double(attempt) / rate);
}

namespace {

// Plateau and gain for a given rate, from the normal equations of total = plateau + gain * (-e).
std::optional<LearningCurve> fitAt(std::span<const double> totals, double rate) {
    const auto n = double(totals.size());
    double e1 = 0.0, e2 = 0.0, t1 = 0.0, te = 0.0;
    for (std::size_t i = 0; i < totals.size(); ++i) {
        const double e = -std::exp(-double(i) / rate);
        e1 += e, e2 += e * e, t1 += totals[i], te += totals[i] * e;
    }
    const double determinant = n * e2 - e1 * e1;
    if (!(determinant > 1e-12 * n * e2)) return std::nullopt;
    LearningCurve curve;
    curve.rate = rate;
    curve.gain = (n * te - e1 * t1) / determinant;
    curve.plateau = (t1 - curve.gain * e1) / n;
    double left = 0.0;
    for (std::size_t i = 0; i < totals.size(); ++i)
        left += (totals[i] - curve.at(i)) * (totals[i] - curve.at(i));
    curve.rms = std::sqrt(left / n);
    return curve;
}

// Corrected Akaike criterion of a least-squares fit with this variance and number of parameters. The variance
// itself is another parameter.
double akaike(double n, double variance, double parameters) {
    const double k = parameters + 1.0;
    if (n <= k + 1.0) return std::numeric_limits<double>::infinity();
    return n * std::log(variance) + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0);
}

}  // namespace

std::optional<LearningCurve> learningCurve(std::span<const double> totals) {
    constexpr std::size_t kMinTotals = 4;
    constexpr int kRates = 400;
    constexpr double kSlowest = 10.0, kFastest = 0.5;  // kSlowest: in multiples of the number of attempts
    if (totals.size() < kMinTotals) return std::nullopt;
    if (std::any_of(totals.begin(), totals.end(), [](double t) { return !std::isfinite(t); }))
        return std::nullopt;
    const auto [low, high] = std::minmax_element(totals.begin(), totals.end());
    if (*low == *high) return std::nullopt;
    std::optional<LearningCurve> best;
    for (int i = 0; i <= kRates; ++i) {
        const double slowest = kSlowest * double(totals.size());
        const double rate = kFastest * std::pow(slowest / kFastest, double(i) / kRates);
        const auto curve = fitAt(totals, rate);
        if (curve && (!best || curve->rms < best->rms)) best = curve;
    }
    const auto n = double(totals.size());
    double squares = 0.0;
    for (const double total : totals)
        squares += (total - mean(totals)) * (total - mean(totals));
    if (best) best->supported = akaike(n, best->rms * best->rms, 3.0) < akaike(n, squares / n, 1.0);
    return best;
}

std::optional<double> percentileRank(std::span<const double> cohort, double total) noexcept {
    if (cohort.empty() || std::isnan(total)) return std::nullopt;
    double below = 0.0;
    std::size_t count = 0;
    for (const double other : cohort) {
        if (std::isnan(other)) continue;
        ++count;
        below += other < total ? 1.0 : other == total ? 0.5 : 0.0;
    }
    if (count == 0) return std::nullopt;
    return below / double(count);
}

}  // namespace stylet::training
